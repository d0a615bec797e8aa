// SPDX-FileCopyrightText: 2026 the evermap authors
// SPDX-License-Identifier: BSD-3-Clause
#include <set>

#include <evermap/geometry/detail/neighbourhood.hpp>
#include <evermap/map/detail/leaf_changes.hpp>
#include <evermap/map/detail/surface_changes.hpp>
#include <evermap/map/map_difference.hpp>

namespace evermap {
namespace {

/// Groups voxels that touch, by flooding from each that is not in a group yet.
void add_pieces(const std::vector<VoxelKey>& keys, const VoxelGrid& grid, bool has_come,
                std::vector<SurfaceChange>& changes) {
  constexpr std::size_t kNoise = 2;  // leaves
  std::set<VoxelKey> left(keys.begin(), keys.end());
  while (!left.empty()) {
    SurfaceChange piece{has_come, {}, 0};
    std::vector<VoxelKey> open = {left.extract(left.begin()).value()};
    while (!open.empty()) {
      const VoxelKey key = open.back();
      open.pop_back();
      ++piece.leaves;
      const Eigen::Vector3d half = Eigen::Vector3d::Constant(grid.edge / 2);
      piece.box.extend(Eigen::AlignedBox3d(grid.center(key) - half, grid.center(key) + half));
      for_each_in_neighbourhood(key, [&](VoxelKey near) {
        if (auto found = left.extract(near)) open.push_back(found.value());
      });
    }
    if (piece.leaves > kNoise) changes.push_back(piece);
  }
}

}  // namespace

bool shows_surface(const Octree& octree, VoxelKey key, const Eigen::Vector3d& p_map) {
  const double tolerance = MapDifference::kTolerance * octree.grid().edge;
  const auto leaf_shows = [&](VoxelKey near) {
    const Leaf* leaf = octree.find(near);
    if (leaf == nullptr || !leaf->occupied()) return false;
    Gaussian surface = octree.gaussian(near, *leaf);
    surface.covariance += tolerance * tolerance * Eigen::Matrix3d::Identity();
    return mahalanobis_squared(p_map, surface) <= kChiSquared99;
  };
  return leaf_shows(key) || any_in_neighbourhood(key, leaf_shows);  // mostly the voxel's own leaf does
}

MapDifference compare(const Octree& before, const Octree& after) {
  MapDifference difference;
  // A leaf that stayed as it was shows its own surface.
  for (const LeafChange& change : changes_between(before, after)) {
    const Leaf* old_leaf = before.find(change.key);
    const bool was_occupied = old_leaf != nullptr && old_leaf->occupied();
    if (was_occupied && !change.leaf.occupied()) {
      if (shows_surface(after, change.key, before.gaussian(change.key, *old_leaf).mean)) {
        ++difference.border_removed;
      } else {
        difference.removed.push_back(change.key);
      }
    }
    if (!change.leaf.occupied()) continue;
    if (shows_surface(before, change.key, after.gaussian(change.key, change.leaf).mean)) {
      difference.border_added += was_occupied ? 0 : 1;
    } else {
      (was_occupied ? difference.moved : difference.added).push_back(change.key);
    }
  }
  return difference;
}

std::vector<SurfaceChange> surface_changes(const Octree& before, const Octree& after) {
  const MapDifference difference = compare(before, after);
  std::vector<SurfaceChange> changes;
  add_pieces(difference.removed, after.grid(), false, changes);
  add_pieces(difference.added, after.grid(), true, changes);
  return changes;
}

}  // namespace evermap
