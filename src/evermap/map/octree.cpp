// SPDX-FileCopyrightText: 2026 the evermap authors
// SPDX-License-Identifier: BSD-3-Clause
#include <algorithm>

#include <evermap/map/octree.hpp>

namespace evermap {

void Octree::erase(VoxelKey key) {
  const auto found = blocks_.find(key.block());
  if (found == blocks_.end()) return;
  Block& block = found->second;
  Brick* brick = block.find(key.brick_in_block());
  if (brick == nullptr) return;
  const std::size_t before = brick->size();
  brick->erase(key.voxel_in_brick());
  leaf_count_ -= before - brick->size();
  if (brick->empty()) block.erase(key.brick_in_block());
  if (block.empty()) blocks_.erase(found);
}

std::vector<std::uint64_t> Octree::sorted_block_keys() const {
  std::vector<std::uint64_t> keys;
  keys.reserve(blocks_.size());
  for (const auto& [key, block] : blocks_) keys.push_back(key);
  std::sort(keys.begin(), keys.end());
  return keys;
}

std::size_t Octree::memory_bytes() const {
  std::size_t bytes = sizeof(*this) + blocks_.bucket_count() * sizeof(void*);
  for (const auto& [key, block] : blocks_) {
    bytes += sizeof(key) + sizeof(block) + 2 * sizeof(void*) + block.capacity() * sizeof(Brick);
    block.for_each([&](int, const Brick& brick) { bytes += brick.capacity() * sizeof(Leaf); });
  }
  return bytes;
}

}  // namespace evermap
