// SPDX-FileCopyrightText: 2026 the evermap authors
// SPDX-License-Identifier: BSD-3-Clause
#include "experiments/redlight_dataset.hpp"

#include <algorithm>
#include <array>
#include <cstdint>
#include <stdexcept>
#include <unordered_map>
#include <utility>

#include <evermap/evaluation/labelled_drive.hpp>
#include <evermap/geometry/voxel_key.hpp>
#include <evermap/io/detail/scan_folder.hpp>

namespace evermap {
namespace {

constexpr double kReach = 40;  ///< [m] from the sensor: beyond, hits are too sparse to tell what moves
constexpr double kTruthSpacing = 0.05;  ///< [m]

constexpr std::size_t kStretches = 3;
using Stretches = std::array<Points, kStretches>;

/// Points of the begin, the middle and the end of the run; what passes is not in two of them at one place.
Stretches stretches_of(const std::vector<AlignedScan>& scans) {
  constexpr std::size_t kBetween = 2;  // scans
  Stretches stretches;
  for (std::size_t i = 0; i < scans.size(); ++i) {
    const std::size_t stretch = i * kStretches / scans.size();
    const bool is_near_next = (i + kBetween) * kStretches / scans.size() != stretch;
    if (is_near_next && i + kBetween < scans.size()) continue;
    const Points& points = scans[i].scan.p_sensor;
    stretches.at(stretch).insert(stretches.at(stretch).end(), points.begin(), points.end());
  }
  for (Points& stretch : stretches) stretch = thinned(stretch, kTruthSpacing);
  return stretches;
}

/// Of each point, whether fewer than two stretches know it.
std::vector<bool> are_transient(const Points& points, const Stretches& stretches) {
  constexpr double kSame = 0.15;  // [m] between hits of one surface
  std::vector<int> found(points.size(), 0);
  for (const Points& stretch : stretches) {
    const std::vector<double> distances = nearest_distances(points, stretch);
    for (std::size_t k = 0; k < points.size(); ++k) found[k] += distances[k] < kSame ? 1 : 0;
  }
  std::vector<bool> transient(points.size());
  std::transform(found.begin(), found.end(), transient.begin(), [](int times) { return times < 2; });
  return transient;
}

/// The transient points of a scan that are many in one place, vehicles, and apart from them all others, among
/// them the odd leaf of a tree.
struct Parts {
  Points moving;
  Points still;
};
Parts parts_of(const Points& points, std::vector<bool>::const_iterator transient) {
  constexpr std::size_t kMany = 15;
  const VoxelGrid grid{.edge = 1.5};
  const auto cell = [&](const Eigen::Vector3d& p) { return grid.key(p).value_or(VoxelKey()).bits(); };
  std::unordered_map<std::uint64_t, std::size_t> counts;
  for (std::size_t k = 0; k < points.size(); ++k) {
    if (transient[static_cast<std::ptrdiff_t>(k)]) ++counts[cell(points[k])];
  }
  Parts parts;
  for (std::size_t k = 0; k < points.size(); ++k) {
    const bool moves = transient[static_cast<std::ptrdiff_t>(k)] && counts[cell(points[k])] >= kMany;
    (moves ? parts.moving : parts.still).push_back(points[k]);
  }
  return parts;
}

}  // namespace

RedlightDataset::RedlightDataset(const std::filesystem::path& folder) {
  ScanFolder source(folder / "scans");
  while (auto scan = source.next()) scans_.push_back({std::move(*scan), Pose{}});
  if (scans_.size() < kScans) throw std::runtime_error(folder.string() + ": has too few scans");
  scans_.erase(scans_.begin(), scans_.end() - kScans);
  lidar.min_range = 2.5;  // the vehicle's own roof
  position_sigma = DriveScore::kPoseSigma;
  const Eigen::Vector2d reach(kReach, kReach);
  area = {-reach, reach};
  view = {-0.75 * reach, 0.75 * reach};

  std::vector<Points> points;
  Points all;
  for (const AlignedScan& s : scans_) {
    points.push_back(within(area, s.scan.p_sensor));
    std::erase_if(points.back(), [&](const Eigen::Vector3d& p) { return p.norm() < lidar.min_range; });
    all.insert(all.end(), points.back().begin(), points.back().end());
  }
  const std::vector<bool> transient = are_transient(all, stretches_of(scans_));
  DynamicObject traffic{"traffic", {}};
  auto next = transient.begin();
  for (const Points& of_scan : points) {
    Parts parts = parts_of(of_scan, next);
    next += static_cast<std::ptrdiff_t>(of_scan.size());
    traffic.p_map.push_back(std::move(parts.moving));
    surface_.insert(surface_.end(), parts.still.begin(), parts.still.end());
  }
  surface_ = thinned(surface_, kTruthSpacing);
  dynamic_objects_.push_back(std::move(traffic));
}

Truth RedlightDataset::truth(std::size_t) const {
  const Points samples = thinned(surface_, 2 * kTruthSpacing);
  return {samples, samples, [this](const Points& points) { return nearest_distances(points, surface_); }};
}

Changes RedlightDataset::changes(double leaf) const {
  return {contradictable(thinned(surface_, 2 * kTruthSpacing), VoxelGrid{.edge = leaf}, rays()), {}};
}

}  // namespace evermap
