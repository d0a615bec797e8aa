// SPDX-FileCopyrightText: 2026 the evermap authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstddef>
#include <vector>

#include "report.hpp"
#include <evermap/evaluation/contender.hpp>
#include <evermap/localization/localizer.hpp>

namespace evermap {

/// What registration needs of a grid: a Gaussian for each of its occupied voxels, given by their centers,
/// made of the centers around it, as GICP makes them of points.
Octree gaussians_of_grid(const Points& centers, double edge);

/// Drives with a contender's map and no poses: localizes each scan in the map and lets the map have it there.
class Pilot {
 public:
  /// `start`: pose of the first scan. REQUIRES: the contender outlives the pilot and has its first map.
  Pilot(Contender& contender, double edge, const Pose& start, const LidarParameters& lidar);

  /// `T_odom_sensor`: what odometry says, if there is any. `T_map_sensor_true` is noted, not used.
  void take(const Scan& scan, double time, const std::optional<Pose>& T_odom_sensor,
            const Pose& T_map_sensor_true);

  /// "error": [m] by scan; at the end "ATE" [m], "worst" [m], "rotation" [deg], shares "lost" and "tracked".
  Json errors() const;

 private:
  static constexpr std::size_t kRefresh = 10;  ///< scans after which a grid's Gaussians are made anew

  const Octree& target();

  Contender& contender_;
  double edge_;
  Localizer localizer_;
  Octree grid_target_;
  std::size_t outdated_by_ = kRefresh;  ///< scans written since grid_target_ was made
  std::size_t tracked_ = 0;
  std::vector<Pose> true_, found_;
};

}  // namespace evermap
