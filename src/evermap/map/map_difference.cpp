// SPDX-FileCopyrightText: 2026 the evermap authors
// SPDX-License-Identifier: BSD-3-Clause
#include <evermap/geometry/detail/neighbourhood.hpp>
#include <evermap/map/detail/leaf_changes.hpp>
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
  // A leaf that stayed as it was shows its own surface.
  for (const LeafChange& change : changes_between(before, after)) {
    const Leaf* old_leaf = before.find(change.key);
    const bool was_occupied = old_leaf != nullptr && old_leaf->occupied();
    if (was_occupied && !change.leaf.occupied()) {
      if (shows(after, change.key, before.gaussian(change.key, *old_leaf).mean)) {
        ++difference.border_removed;
      } else {
        difference.removed.push_back(change.key);
      }
    }
    if (!change.leaf.occupied()) continue;
    if (shows(before, change.key, after.gaussian(change.key, change.leaf).mean)) {
      difference.border_added += was_occupied ? 0 : 1;
    } else {
      (was_occupied ? difference.moved : difference.added).push_back(change.key);
    }
  }
  return difference;
}

}  // namespace evermap
