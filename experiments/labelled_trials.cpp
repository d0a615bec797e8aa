// SPDX-FileCopyrightText: 2026 the evermap authors
// SPDX-License-Identifier: BSD-3-Clause
#include "experiments/labelled_trials.hpp"

#include <stdexcept>
#include <utility>

#include <evermap/evaluation/map_claims.hpp>
#include <evermap/io/detail/labelled_boxes.hpp>
#include <evermap/io/detail/scan_folder.hpp>
#include <evermap/maintenance/map_maintainer.hpp>

namespace evermap {
namespace {

constexpr double kStillThere = 0.03;  // [m] from a point of the last scans; farther may be another car
constexpr double kMinRange = 2.5;     // [m] the vehicle's own roof

Parameters parameters_for(const UpdateParameters& update) {
  LidarParameters lidar;
  lidar.min_range = kMinRange;
  return {lidar, update, {}, {}};
}

}  // namespace

DriveTrial::DriveTrial(const std::filesystem::path& folder, std::size_t scans)
    : boxes_(read_labelled_boxes(folder / "boxes_velo.csv")) {
  PosedScans source(folder / "scans", (folder / "poses_kitti.txt").string(), LidarParameters{}.scan_period);
  while (scans_.size() < scans) {
    auto posed = source.next();
    if (!posed) break;
    scans_.push_back(std::move(*posed));
  }
  boxes_.resize(scans_.size());
}

DriveScore DriveTrial::run(double edge, const UpdateParameters& update) const {
  const Parameters parameters = parameters_for(update);
  MapMaintainer builder(Octree(VoxelGrid{edge}), parameters, MapMode::kMapping);
  for (const PosedScan& s : scans_) builder.process(s.scan, s.T_map_sensor);
  MapMaintainer maintainer(builder.map(), parameters);
  for (const PosedScan& s : scans_) maintainer.process(s.scan, s.T_map_sensor);
  const Octree map = maintainer.map();
  DriveScore score;
  for (std::size_t i = 0; i < scans_.size(); ++i) {
    add_to_score(score, scans_[i].scan, scans_[i].T_map_sensor, boxes_[i],
                 i + DriveScore::kLastScans >= scans_.size(),
                 [&](const Eigen::Vector3d& p_map) { return claims(map, p_map, DriveScore::kPoseSigma); });
  }
  return score;
}

RedlightTrial::RedlightTrial(const std::filesystem::path& folder) {
  ScanFolder source(folder / "scans");
  while (auto scan = source.next()) scans_.push_back(std::move(*scan));
  if (scans_.size() < kUpdated + kBuilt) throw std::runtime_error(folder.string() + ": has too few scans");
  scans_.erase(scans_.begin(), scans_.end() - kUpdated - kBuilt);
  Points early;
  Points late;
  for (std::size_t i = 0; i < scans_.size(); ++i) {
    Points& points = i < kBuilt ? early : late;
    if (i < kBuilt || i + 3 >= scans_.size()) {
      points.insert(points.end(), scans_[i].p_sensor.begin(), scans_[i].p_sensor.end());
    }
  }
  const std::vector<double> distances = nearest_distances(early, late);
  for (std::size_t i = 0; i < early.size(); ++i) {
    if (distances[i] < kStillThere && early[i].norm() > kMinRange) still_there_.push_back(early[i]);
  }
}

double RedlightTrial::run(double edge, const UpdateParameters& update) const {
  const Parameters parameters = parameters_for(update);
  MapMaintainer builder(Octree(VoxelGrid{edge}), parameters, MapMode::kMapping);
  for (std::size_t i = 0; i < kBuilt; ++i) builder.process(scans_[i], Pose{});
  MapMaintainer maintainer(builder.map(), parameters);
  for (std::size_t i = kBuilt; i < scans_.size(); ++i) maintainer.process(scans_[i], Pose{});
  const Octree map = maintainer.map();
  return fraction_true(
      still_there_, [&](const Eigen::Vector3d& p_map) { return claims(map, p_map, DriveScore::kPoseSigma); });
}

}  // namespace evermap
