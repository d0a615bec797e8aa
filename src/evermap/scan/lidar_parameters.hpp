// SPDX-FileCopyrightText: 2026 the evermap authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

namespace evermap {

/// The sensor: which of its returns are used, how exact they are, and when they come.
struct LidarParameters {
  double min_range = 0.5;     ///< [m] nearer returns are the vehicle itself
  double max_range = 200.0;   ///< [m]
  double range_sigma = 0.02;  ///< [m] standard deviation of a return's distance
  double scan_period = 0.1;   ///< [s] from the first return of a scan to the last
};

}  // namespace evermap
