// SPDX-FileCopyrightText: 2026 the evermap authors
// SPDX-License-Identifier: BSD-3-Clause
#include "yard_trial.hpp"

#include <utility>

#include <evermap/evaluation/map_claims.hpp>
#include <evermap/evaluation/ray_coverage.hpp>
#include <evermap/update/map_updater.hpp>

namespace evermap {
namespace {

constexpr double kSampleSpacing = 0.05;  // [m] between samples of the true surface
constexpr double kObservedReach = 0.1;   // [m] from a ray's end to the surface that it observed

std::vector<ScanRays> rays_of(const std::vector<Scan>& scans, const std::vector<Pose>& T_map_sensor) {
  std::vector<ScanRays> rays;
  for (std::size_t i = 0; i < scans.size(); ++i) {
    rays.push_back({T_map_sensor[i].translation, {}});
    for (const Eigen::Vector3d& p_sensor : scans[i].p_sensor)
      rays.back().ends.push_back(T_map_sensor[i] * p_sensor);
  }
  return rays;
}

}  // namespace

YardTrial::YardTrial(double leaf_edge, std::vector<Pose> T_map_sensor, const Yard& yard)
    : T_map_sensor_(std::move(T_map_sensor)), initial_map_(VoxelGrid{leaf_edge}) {
  const Simulator simulator(yard.now);
  for (std::size_t i = 0; i < T_map_sensor_.size(); ++i) {
    scans_.push_back(simulator.scan(T_map_sensor_[i], LidarModel{}, i));
  }
  for (const SurfaceSample& sample : sample_surface(yard.before, kSampleSpacing)) {
    initial_surface_.push_back(sample.p_map);
  }
  Scan survey;
  survey.p_sensor = initial_surface_;
  add_cloud(initial_map_, survey, Pose{}, UpdateParameters{});

  const ChangeTruth truth = change_truth(yard.before, yard.now, kSampleSpacing, leaf_edge / 2);
  const std::vector<ScanRays> rays = rays_of(scans_, T_map_sensor_);
  unchanged_ = contradictable(truth.unchanged, initial_map_.grid(), rays);
  removed_ = contradictable(truth.removed, initial_map_.grid(), rays);
  observed_ = observed(truth.now, rays, kObservedReach);
}

YardScore YardTrial::score(const std::function<bool(const Eigen::Vector3d&)>& claim,
                           const Points& map) const {
  return {share_true(unchanged_, claim), 1 - share_true(removed_, claim), compare_surfaces(observed_, map)};
}

YardScore YardTrial::score(const Octree& octree) const {
  const double range_sigma = LidarModel{}.range_sigma;
  return score([&](const Eigen::Vector3d& p_map) { return claims(octree, p_map, range_sigma); },
               surface_points(octree));
}

}  // namespace evermap
