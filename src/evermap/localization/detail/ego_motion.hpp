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

/// How the sensor moved from one moment to another by odometry; none where it does not tell both.
inline std::optional<Pose> moved_by_odometry(const EgoMotion& from, const EgoMotion& to) {
  if (!from.T_odom_sensor || !to.T_odom_sensor) return std::nullopt;
  return from.T_odom_sensor->inverse() * *to.T_odom_sensor;
}

}  // namespace evermap
