// SPDX-FileCopyrightText: 2026 the evermap authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <Eigen/Geometry>

namespace evermap {

/// The sensor: which of its returns are used, how exact they are, and when they come.
struct LidarParameters {
  double min_range = 0.5;     ///< [m]
  double max_range = 200.0;   ///< [m]
  double range_sigma = 0.02;  ///< [m] standard deviation of a return's distance
  double scan_period = 0.1;   ///< [s] from the first return of a scan to the last
  /// [m] of the sensor's frame: returns in it are the vehicle itself. Empty: none.
  Eigen::AlignedBox3d vehicle_box{};
};

}  // namespace evermap
