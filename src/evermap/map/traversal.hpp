// SPDX-FileCopyrightText: 2026 the evermap authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>

#include <evermap/geometry/ray.hpp>
#include <evermap/map/detail/voxel_walk.hpp>
#include <evermap/map/octree.hpp>

namespace evermap {

/// Visits every leaf along a ray, pending ones too, front to back: `visit(key, leaf, entry, exit)`, the
/// distances from the ray's origin in metres; the last exit may lie beyond the ray's end. Visits nothing when
/// an end of the ray is beyond the range of keys. Const on the map: any number of threads may traverse it at
/// once. For the many rays of a scan, RayFan is faster.
template <class Visit>
void traverse(const Octree& octree, const Ray& ray, Visit&& visit) {
  constexpr int kBlockLevel = 6;
  constexpr int kBrickLevel = 3;
  const auto start = octree.grid().voxel(ray.origin);
  if (!start || !octree.grid().voxel(ray.end)) return;
  const double length = ray.length();
  VoxelWalk walk(VoxelRay::of(octree.grid(), ray), *start);
  // A ray that ends on the border of the range of keys may step across it.
  const auto on_grid = [&walk] { return walk.inside() && VoxelKey::in_range(walk.voxel()); };
  while (on_grid()) {
    VoxelKey key = VoxelKey::from_voxel(walk.voxel());
    const std::uint64_t block_key = key.block();
    const Octree::Block* block = octree.find_block(block_key);
    if (block == nullptr) {
      walk.leap(walk.exit(kBlockLevel));
      continue;
    }
    for (; on_grid() && key.block() == block_key; key = VoxelKey::from_voxel(walk.voxel())) {
      const Brick* brick = block->find(key.brick_in_block());
      if (brick == nullptr) {
        walk.leap(walk.exit(kBrickLevel));
        continue;
      }
      const Leaf* leaf = brick->find(key.voxel_in_brick());
      if (leaf != nullptr) visit(key, *leaf, walk.entry() * length, walk.exit() * length);
      walk.step();
    }
  }
}

/// As `traverse`, but the occupied leaves only.
template <class Visit>
void for_each_occupied(const Octree& octree, const Ray& ray, Visit&& visit) {
  traverse(octree, ray, [&](VoxelKey key, const Leaf& leaf, double entry, double exit) {
    if (leaf.occupied()) visit(key, leaf, entry, exit);
  });
}

}  // namespace evermap
