// SPDX-FileCopyrightText: 2026 the evermap authors
// SPDX-License-Identifier: BSD-3-Clause
#include <algorithm>

#include <evermap/geometry/detail/for_each_index.hpp>
#include <evermap/map/octree.hpp>

namespace evermap {
namespace {

constexpr std::size_t kBlocksPerTask = 4;

}  // namespace

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

std::vector<std::uint64_t> Octree::block_keys() const {
  std::vector<std::uint64_t> keys;
  keys.reserve(blocks_.size());
  for (const auto& [key, block] : blocks_) keys.push_back(key);
  std::sort(keys.begin(), keys.end());
  return keys;
}

std::vector<PlacedBrick> Octree::bricks_in(const Eigen::AlignedBox3i& voxels) const {
  std::vector<PlacedBrick> all;
  if (voxels.isEmpty()) return all;
  const std::vector<std::uint64_t> keys = block_keys_in(voxels);
  std::vector<std::vector<PlacedBrick>> found(keys.size());
  for_each_index(found.size(), kBlocksPerTask, [&](std::size_t i) {
    const Block& block = *find_block(keys[i]);
    found[i].reserve(block.size());
    block.for_each([&](int index, const Brick& brick) {
      const VoxelKey first = VoxelKey::first_of_block(keys[i]).first_of_brick(index);
      const Eigen::Vector3i corner = first.voxel();
      const Eigen::AlignedBox3i extent(corner, corner.array() + 7);
      if (voxels.intersects(extent)) found[i].push_back({&brick, first, corner});
    });
  });
  for (const auto& in_block : found) all.insert(all.end(), in_block.begin(), in_block.end());
  return all;
}

std::vector<std::uint64_t> Octree::block_keys_in(const Eigen::AlignedBox3i& voxels) const {
  const auto block_of = [](const Eigen::Vector3i& v) { return v.unaryExpr([](int i) { return i >> 6; }); };
  const Eigen::AlignedBox3i box(block_of(voxels.min()), block_of(voxels.max()));
  const Eigen::Vector3i size = box.sizes().array() + 1;
  std::vector<std::uint64_t> keys;
  // Whichever is less work: to look up every block of the box, or to look at every block of the map.
  if (size.cast<double>().prod() < static_cast<double>(blocks_.size())) {
    for (int i = 0; i < size.prod(); ++i) {
      const Eigen::Vector3i at(i % size.x(), i / size.x() % size.y(), i / size.x() / size.y());
      const std::uint64_t key = VoxelKey::from_voxel(64 * (box.min() + at)).block();
      if (blocks_.contains(key)) keys.push_back(key);
    }
  } else {
    for (const auto& [key, block] : blocks_) {
      if (box.contains(block_of(VoxelKey::first_of_block(key).voxel()))) keys.push_back(key);
    }
  }
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
