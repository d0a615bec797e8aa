// SPDX-FileCopyrightText: 2026 the evermap authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>

#include <evermap/map/octree.hpp>

namespace evermap {

/// Calls visit(key, leaf) for every leaf of a block, if the map has it, in ascending order of keys.
template <class Visit>
void for_each_leaf_of(const Octree& map, std::uint64_t block_key, Visit&& visit) {
  const Octree::Block* block = map.find_block(block_key);
  if (block == nullptr) return;
  const VoxelKey first = VoxelKey::first_of_block(block_key);
  block->for_each([&](int brick_index, const Brick& brick) {
    const VoxelKey in_brick = first.first_of_brick(brick_index);
    brick.for_each([&](int voxel, const Leaf& leaf) { visit(in_brick.with_voxel(voxel), leaf); });
  });
}

}  // namespace evermap
