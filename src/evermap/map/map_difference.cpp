// SPDX-FileCopyrightText: 2026 the evermap authors
// SPDX-License-Identifier: BSD-3-Clause
#include <evermap/geometry/detail/neighbourhood.hpp>
#include <evermap/map/map_difference.hpp>

namespace evermap {
namespace {

/// Whether an occupied leaf in or around this voxel shows surface at `p_map`.
bool shows(const Octree& octree, VoxelKey key, const Eigen::Vector3d& p_map) {
  const double tolerance = MapDifference::kTolerance * octree.grid().edge;
  return any_in_neighbourhood(key, [&](VoxelKey near) {
    const Leaf* leaf = octree.find(near);
    if (leaf == nullptr || !leaf->occupied()) return false;
    Gaussian surface = octree.gaussian(near, *leaf);
    surface.covariance += tolerance * tolerance * Eigen::Matrix3d::Identity();
    return mahalanobis_squared(p_map, surface) <= kChiSquared99;
  });
}

}  // namespace

MapDifference compare(const Octree& before, const Octree& after) {
  MapDifference difference;
  before.for_each_leaf([&](VoxelKey key, const Leaf& leaf) {
    if (!leaf.occupied() || after.is_occupied(key)) return;
    if (shows(after, key, before.gaussian(key, leaf).mean)) {
      ++difference.border_removed;
    } else {
      difference.removed.push_back(key);
    }
  });
  after.for_each_leaf([&](VoxelKey key, const Leaf& leaf) {
    if (!leaf.occupied()) return;
    const bool was_occupied = before.is_occupied(key);
    if (shows(before, key, after.gaussian(key, leaf).mean)) {
      difference.border_added += was_occupied ? 0 : 1;
    } else {
      (was_occupied ? difference.moved : difference.added).push_back(key);
    }
  });
  return difference;
}

}  // namespace evermap
