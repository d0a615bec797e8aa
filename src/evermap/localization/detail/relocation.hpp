// SPDX-FileCopyrightText: 2026 the evermap authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <numbers>

#include <evermap/localization/detail/registration.hpp>

namespace evermap {

/// Where to look for a lost robot: around the pose where it was last known.
struct RelocationParameters {
  double reach = 5;                               ///< [m] to either side, in x and y
  double turn = 20 * std::numbers::pi / 180;      ///< [rad] to either side, about z
  double step = 1;                                ///< [m] between tries
  double turn_step = 5 * std::numbers::pi / 180;  ///< [rad]
  int finalists = 5;                              ///< places that are registered in full
  double rival = 0.9;  ///< of the winner's inlier fraction: another place that reaches it makes it ambiguous
};

/// Searches the surroundings of a pose: scores every offset on a coarse view of the map, registers the best
/// ones. One score decides nothing: where two places fit alike (an aisle of equal posts) the outcome is
/// RejectReason::kAmbiguous. Assumes that z is up. Reads the map only; same result for any number of threads.
Registration relocate(const Octree& map, const Scan& scan, const Pose& T_map_sensor_last,
                      const LidarParameters& lidar, const RegistrationParameters& registration,
                      const RelocationParameters& parameters);

}  // namespace evermap
