// SPDX-FileCopyrightText: 2026 the evermap authors
// SPDX-License-Identifier: BSD-3-Clause
#include <cmath>

#include <Eigen/LU>

#include <evermap/localization/detail/correspondence.hpp>
#include <evermap/map/detail/leaf_finder.hpp>

namespace evermap {
namespace {

/// How near to a face a bundle may belong beyond it although its own voxel holds a leaf; a fraction of the
/// edge.
constexpr double kNearFace = 0.2;

/// A leaf that a bundle may belong to.
struct Candidate {
  std::size_t bundle;
  Eigen::Vector3i voxel;
  const Leaf* leaf;
};

/// The candidates of all bundles, in their order. Leaves lie all over the memory: all are asked for before
/// any is used.
std::vector<Candidate> candidates(const Octree& map, std::span<const Gaussian> bundles) {
  std::vector<Candidate> found;
  found.reserve(4 * bundles.size());
  LeafFinder finder(map);
  const auto ask = [&](std::size_t bundle, const Eigen::Vector3i& voxel) {
    const Leaf* leaf = VoxelKey::in_range(voxel) ? finder.find(VoxelKey::from_voxel(voxel)) : nullptr;
    if (leaf == nullptr) return false;
    leaf->prefetch();
    found.push_back({bundle, voxel, leaf});
    return true;
  };
  for (std::size_t i = 0; i < bundles.size(); ++i) {
    const auto voxel = map.grid().voxel(bundles[i].mean);
    if (!voxel) continue;
    const double least = ask(i, *voxel) ? (0.5 - kNearFace) * map.grid().edge : 0;
    const Eigen::Vector3d from_center = bundles[i].mean - map.grid().center(*voxel);
    for (int axis = 0; axis < 3; ++axis) {
      if (std::abs(from_center[axis]) < least) continue;
      ask(i, *voxel + (from_center[axis] < 0 ? -1 : 1) * Eigen::Vector3i::Unit(axis));
    }
  }
  return found;
}

}  // namespace

std::vector<std::optional<Correspondence>> correspond(const Octree& map,
                                                      std::span<const Gaussian> bundles_sensor,
                                                      const Pose& T_map_sensor) {
  std::vector<Gaussian> bundles;
  bundles.reserve(bundles_sensor.size());
  for (const Gaussian& bundle : bundles_sensor) bundles.push_back(transform(T_map_sensor, bundle));
  std::vector<std::optional<Correspondence>> matches(bundles.size());
  for (const auto& [i, voxel, leaf] : candidates(map, bundles)) {
    if (!leaf->occupied()) continue;
    std::optional<Correspondence>& best = matches[i];
    const Gaussian& bundle = bundles[i];
    const Eigen::Vector3d mean_leaf = leaf->gaussian(map.grid().center(voxel)).mean;
    const Eigen::Vector3d residual = mean_leaf - bundle.mean;
    const Eigen::Matrix3d covariance = leaf->covariance_matrix() + bundle.covariance;
    // No eigenvalue exceeds the trace, so this is the least that e' M e can be; it spares most inverses.
    if (best && residual.squaredNorm() >= best->mahalanobis_squared * covariance.trace()) continue;
    const Eigen::Matrix3d information = covariance.inverse();
    const double mahalanobis_squared = residual.dot(information * residual);
    if (best && best->mahalanobis_squared <= mahalanobis_squared) continue;
    const double occupancy = 1 / (1 + std::exp(-static_cast<double>(leaf->log_odds)));
    best = {mean_leaf, information, mahalanobis_squared, occupancy};
  }
  return matches;
}

}  // namespace evermap
