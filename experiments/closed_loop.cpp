// SPDX-FileCopyrightText: 2026 the evermap authors
// SPDX-License-Identifier: BSD-3-Clause
#include "experiments/closed_loop.hpp"

#include <numbers>
#include <string>

#include <evermap/evaluation/trajectory_metrics.hpp>
#include <evermap/geometry/detail/neighbourhood.hpp>

namespace evermap {

Octree gaussians_of_grid(const Points& centers, double edge) {
  constexpr double kSure = 3;       // log-odds
  constexpr double kThinnest = 10;  // times thinner than a voxel a surface may seem
  Octree occupied(VoxelGrid{.edge = edge});
  for (const Eigen::Vector3d& center : centers) {
    if (const auto key = occupied.grid().key(center)) occupied.find_or_insert(*key).log_odds = kSure;
  }
  Octree gaussians = occupied;
  occupied.for_each_leaf([&](VoxelKey key, const Leaf&) {
    const auto point = [&](VoxelKey at) {
      return Gaussian{occupied.grid().center(at), Eigen::Matrix3d::Zero(), 1};
    };
    Gaussian around = point(key);
    for_each_in_neighbourhood(key, [&](VoxelKey near) {
      if (near != key && occupied.find(near) != nullptr) around = merge(around, point(near));
    });
    around.covariance = floor_eigenvalues(around.covariance, edge * edge / (kThinnest * kThinnest));
    gaussians.find(key)->set_gaussian(around, occupied.grid().center(key));
  });
  return gaussians;
}

ClosedLoop::ClosedLoop(Mapper& mapper, double edge, const Pose& start, const LidarParameters& lidar)
    : mapper_(mapper),
      edge_(edge),
      start_(start),
      localizer_(start, lidar, LocalizationParameters{}),
      grid_target_(VoxelGrid{.edge = edge}) {}

void ClosedLoop::process(const Scan& scan, double time, const std::optional<Pose>& T_odom_sensor,
                         const Pose& T_map_sensor_true) {
  if (const auto result = mapper_.process(scan, time, T_odom_sensor)) {
    note(result->T_map_sensor, result->state);
  } else {
    const Localization found = localize_in_grid(scan, time, T_odom_sensor);
    note(found.T_map_sensor, found.state);
  }
  true_.push_back(T_map_sensor_true);
}

Localization ClosedLoop::localize_in_grid(const Scan& scan, double time,
                                          const std::optional<Pose>& T_odom_sensor) {
  if (outdated_by_ >= kRefresh) {
    grid_target_ = gaussians_of_grid(mapper_.surface(), edge_);
    outdated_by_ = 0;
  }
  const EgoMotion ego{T_odom_sensor, {}};
  // The first scan is at the given pose: at its start, a localizer expects more of a map than a grid can
  // tell.
  if (found_.empty()) {
    localizer_.begin(start_, time, ego);
    mapper_.update(scan, start_);
    Localization first;
    first.T_map_sensor = start_;
    first.state = localizer_.state();
    return first;
  }
  Localization found = localizer_.propose(grid_target_, scan, time, ego);
  if (found.is_writable()) {
    mapper_.update(scan, found.T_map_sensor);
    ++outdated_by_;
  }
  localizer_.conclude(found);
  return found;
}

void ClosedLoop::note(const Pose& T_map_sensor, TrackingState state) {
  tracked_ += state == TrackingState::kTracking ? 1 : 0;
  lost_lately_ = state == TrackingState::kLost ? lost_lately_ + 1 : 0;
  found_.push_back(T_map_sensor);
}

void ClosedLoop::stand_lost(const Pose& T_map_sensor_true) {
  note(Pose(found_.back()), TrackingState::kLost);
  true_.push_back(T_map_sensor_true);
}

Json ClosedLoop::errors() const {
  const TrajectoryError error = compare_trajectories(true_, found_);
  return {{"error", error.translation},
          {"ATE", error.translation_rmse()},
          {"worst", error.translation_max()},
          {"rotation", error.rotation_rmse() * 180 / std::numbers::pi},
          {"lost", error.fraction_lost()},
          {"tracked", static_cast<double>(tracked_) / static_cast<double>(found_.size())}};
}

}  // namespace evermap
