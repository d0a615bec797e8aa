// SPDX-FileCopyrightText: 2026 the evermap authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <numbers>

#include <evermap/localization/detail/registration.hpp>

namespace evermap {

/// Where to look for a lost robot: around the pose where it was last known.
struct RelocationParameters {
  double reach = 5;                          ///< [m] to either side, in x and y
  double turn = std::numbers::pi;            ///< [rad] to either side, about z
  double step = 1;                           ///< [m] between tries
  double turn_step = std::numbers::pi / 18;  ///< [rad]
  int finalists = 5;                         ///< places that are registered in full
};

/// Where a lost robot may be: scores every offset from a pose on a coarse view of the map and registers the
/// best ones. Assumes that z is up. Reads the map only; same result for any number of threads.
std::vector<Registration> places(const Octree& map, const Scan& scan, const Pose& T_map_sensor_last,
                                 const LidarParameters& lidar, const RegistrationParameters& registration,
                                 const RelocationParameters& parameters);

/// Where a scan may be that was registered to `found`, but came to rest too soon: behind a wall, a shelf
/// further on. Looks at every 0.1 m within 0.6 m, in x and y, and registers the places where it fits best.
std::vector<Registration> places_beside(const Octree& map, const Scan& scan, const PoseEstimate& found,
                                        const LidarParameters& lidar,
                                        const RegistrationParameters& registration);

}  // namespace evermap
