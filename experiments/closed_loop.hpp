// SPDX-FileCopyrightText: 2026 the evermap authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstddef>
#include <vector>

#include "report.hpp"
#include <evermap/evaluation/mapper.hpp>
#include <evermap/localization/detail/localizer.hpp>

namespace evermap {

/// What registration needs of a grid: a Gaussian for each of its occupied voxels, given by their centers,
/// made of the centers around it, as GICP makes them of points.
Octree gaussians_of_grid(const Points& centers, double edge);

/// The closed loop over any mapper: a map of Gaussians has its own (MapMaintainer); for a grid, each scan is
/// localized in Gaussians made of it, by the same localizer, and given to it there.
class ClosedLoop {
 public:
  /// `start`: pose of the first scan. REQUIRES: the mapper outlives the loop and started there.
  ClosedLoop(Mapper& mapper, double edge, const Pose& start, const LidarParameters& lidar);

  /// `T_odom_sensor`: what odometry says, if there is any. `T_map_sensor_true` is noted, not used.
  void process(const Scan& scan, double time, const std::optional<Pose>& T_odom_sensor,
               const Pose& T_map_sensor_true);

  /// Scans in a row, up to the last one, in which the robot was lost.
  std::size_t lost_lately() const { return lost_lately_; }
  /// A scan at which the robot stands still, lost. REQUIRES: process() was called.
  void stand_lost(const Pose& T_map_sensor_true);

  /// "error": [m] by scan; at the end "ATE" [m], "worst" [m], "rotation" [deg], fractions "lost" and
  /// "tracked".
  Json errors() const;

 private:
  static constexpr std::size_t kRefresh = 10;  ///< scans after which a grid's Gaussians are made anew

  Localization localize_in_grid(const Scan& scan, double time, const std::optional<Pose>& T_odom_sensor);
  void note(const Pose& T_map_sensor, TrackingState state);

  Mapper& mapper_;
  double edge_;
  Pose start_;
  Localizer localizer_;
  Octree grid_target_;
  std::size_t outdated_by_ = kRefresh;  ///< scans written since grid_target_ was made
  std::size_t tracked_ = 0;
  std::size_t lost_lately_ = 0;
  std::vector<Pose> true_, found_;
};

}  // namespace evermap
