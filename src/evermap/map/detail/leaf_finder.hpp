// SPDX-FileCopyrightText: 2026 the evermap authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <limits>
#include <utility>

#include <evermap/map/octree.hpp>

namespace evermap {

/// Finds leaves one after the other, and fast where they follow one another in a brick or a block. Becomes
/// invalid when a leaf is inserted or erased. `Map` is Octree or const Octree. Not thread safe: one for each
/// task.
template <class Map>
class LeafFinder {
 public:
  explicit LeafFinder(Map& map) : map_(map) {}

  auto find(VoxelKey key) {
    if (key.block() != block_at_) {
      block_at_ = key.block();
      block_ = map_.find_block(block_at_);
    }
    if (key.brick() != brick_at_) {
      brick_at_ = key.brick();
      brick_ = block_ ? block_->find(key.brick_in_block()) : nullptr;
    }
    return brick_ ? brick_->find(key.voxel_in_brick()) : nullptr;
  }

 private:
  static constexpr std::uint64_t kNowhere = std::numeric_limits<std::uint64_t>::max();

  Map& map_;
  std::uint64_t block_at_ = kNowhere;
  std::uint64_t brick_at_ = kNowhere;
  decltype(std::declval<Map&>().find_block(0)) block_ = nullptr;
  decltype(std::declval<Map&>().find_brick(VoxelKey())) brick_ = nullptr;
};

}  // namespace evermap
