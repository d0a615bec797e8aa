// SPDX-FileCopyrightText: 2026 the evermap authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstddef>
#include <optional>
#include <vector>

#include <Eigen/Core>

#include <evermap/geometry/pose.hpp>

namespace evermap {

/// Returns of one revolution of the LiDAR (or any point cloud: a survey's cloud is a scan with one sensor
/// pose).
///
/// Class invariant: every point is finite and not at the sensor's origin; readers drop the others and count
/// them.
struct Scan {
  std::vector<Eigen::Vector3d> p_sensor;  ///< [m] sensor frame
  std::vector<float> time_offset;         ///< [s] of each point since the scan began; empty when not recorded
  std::optional<double> time;        ///< [s] since 1970 when its last point was taken; none when not recorded
  std::optional<Pose> T_map_sensor;  ///< sensor pose when the file carries one (PCD VIEWPOINT)
  std::size_t dropped_not_finite = 0;  ///< points with NaN or infinity
  std::size_t dropped_at_origin = 0;   ///< points of zero range, the sensors' way to say "no return"
};

}  // namespace evermap
