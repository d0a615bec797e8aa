// SPDX-FileCopyrightText: 2026 the evermap authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <string_view>

namespace evermap {

/// How well the robot knows where it is.
enum class TrackingState {
  kStarting,  ///< poses fit the map, but its motion is not known yet; see ScanResult::confirmed
  kTracking,  ///< the pose is believed; nothing may be written into the map in any other state
  kDegraded,  ///< the last scans did not pass the gate
  kLost,      ///< too many of them did not; it searches around where it was last
};
std::string_view to_string(TrackingState state);

}  // namespace evermap
