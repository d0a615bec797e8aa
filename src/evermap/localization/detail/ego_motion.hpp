// SPDX-FileCopyrightText: 2026 the evermap authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <optional>

#include <Eigen/Core>

#include <evermap/geometry/pose.hpp>

namespace evermap {

/// What the robot's other sensors tell of its motion at the end of a scan, each in a frame that may drift.
struct EgoMotion {
  std::optional<Pose> T_odom_sensor;                 ///< of wheels, say
  std::optional<Eigen::Matrix3d> R_inertial_sensor;  ///< of a gyroscope
};

}  // namespace evermap
