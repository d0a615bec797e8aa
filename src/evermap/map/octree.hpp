// SPDX-FileCopyrightText: 2026 the evermap authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstddef>
#include <cstdint>
#include <limits>
#include <memory>
#include <unordered_map>
#include <utility>
#include <vector>

#include <Eigen/Core>
#include <Eigen/Geometry>

#include <evermap/geometry/voxel_key.hpp>
#include <evermap/map/detail/brick.hpp>
#include <evermap/map/leaf.hpp>
#include <evermap/map/map_frame.hpp>

namespace evermap {

/// Sparse voxel octree of surface leaves; empty space takes no memory.
///
///   hash table        block                        brick                       leaf
///   block key  ---->  64 x 64 x 64 voxels   ---->  8 x 8 x 8 voxels   ---->    one voxel
///                     512-bit mask of bricks       512-bit mask of leaves      Gaussian, log-odds
///
/// Each wide node is three levels of halving folded into one, so a ray learns from one bit that 8 x 8 x 8
/// voxels hold nothing.
///
/// A copy is a snapshot: it takes one hash table of nodes, and shares each brick until one side changes it.
/// Const members, copying among them, may be called from several threads at once; the others need exclusive
/// access to this map, not to its copies.
class Octree {
 public:
  using Block = WideNode<Brick>;

  explicit Octree(const VoxelGrid& grid, MapFrame frame = {}) : grid_(grid), frame_(std::move(frame)) {}

  const VoxelGrid& grid() const { return grid_; }
  const MapFrame& frame() const { return frame_; }
  std::size_t leaf_count() const { return leaf_count_; }
  bool empty() const { return leaf_count_ == 0; }

  const Block* find_block(std::uint64_t block_key) const {
    const auto found = blocks_.find(block_key);
    return found == blocks_.end() ? nullptr : &found->second;
  }
  Block* find_block(std::uint64_t block_key) {
    const auto found = blocks_.find(block_key);
    return found == blocks_.end() ? nullptr : &found->second;
  }
  /// The brick that holds this voxel, if it holds any leaf.
  const Brick* find_brick(VoxelKey key) const {
    const Block* block = find_block(key.block());
    return block ? block->find(key.brick_in_block()) : nullptr;
  }
  Brick* find_brick(VoxelKey key) {
    Block* block = find_block(key.block());
    return block ? block->find(key.brick_in_block()) : nullptr;
  }

  const Leaf* find(VoxelKey key) const {
    const Brick* brick = find_brick(key);
    return brick ? brick->find(key.voxel_in_brick()) : nullptr;
  }
  Leaf* find(VoxelKey key) {
    Brick* brick = find_brick(key);
    return brick ? brick->find(key.voxel_in_brick()) : nullptr;
  }

  bool is_occupied(VoxelKey key) const {
    const Leaf* leaf = find(key);
    return leaf != nullptr && leaf->occupied();
  }

  /// The leaf of this voxel, made when there is none. Pointers to other leaves become invalid.
  Leaf& find_or_insert(VoxelKey key) {
    Brick& brick = blocks_[key.block()].find_or_insert(key.brick_in_block());
    const std::size_t before = brick.size();
    Leaf& leaf = brick.find_or_insert(key.voxel_in_brick());
    leaf_count_ += brick.size() - before;
    return leaf;
  }

  /// Makes the leaves of these voxels this map's own, so that several threads may change them at once, each
  /// its own leaves. Takes no time when the map has no copies. REQUIRES: keys ascend.
  template <class Items, class KeyOf>
  void own(const Items& items, KeyOf&& key_of);

  /// Puts a whole brick into its place. REQUIRES: the map holds no leaf there, the brick holds some.
  void insert_brick(VoxelKey key, Brick brick) {
    leaf_count_ += brick.size();
    blocks_[key.block()].find_or_insert(key.brick_in_block()) = std::move(brick);
  }

  /// Removes the leaf of this voxel, if any, and nodes left empty. Pointers to other leaves become invalid.
  void erase(VoxelKey key);

  /// The leaf's surface in the map frame.
  Gaussian gaussian(VoxelKey key, const Leaf& leaf) const { return leaf.gaussian(grid_.center(key)); }

  /// Calls visit(key, leaf) for every leaf in ascending order of keys.
  template <class Visit>
  void for_each_leaf(Visit&& visit) const {
    for (const std::uint64_t block_key : block_keys()) {
      const VoxelKey first_of_block = VoxelKey::first_of_block(block_key);
      find_block(block_key)->for_each([&](int brick_index, const Brick& brick) {
        const VoxelKey first = first_of_block.first_of_brick(brick_index);
        brick.for_each(
            [&](int voxel_index, const Leaf& leaf) { visit(first.with_voxel(voxel_index), leaf); });
      });
    }
  }

  /// The bricks that reach into a box of voxels, in ascending order of keys. Runs in parallel.
  std::vector<PlacedBrick> bricks_in(const Eigen::AlignedBox3i& voxels) const;

  /// Of all blocks, ascending.
  std::vector<std::uint64_t> block_keys() const;

  std::size_t memory_bytes() const;  ///< of nodes and leaves, with unused capacity

 private:
  struct BlockHash {
    std::size_t operator()(std::uint64_t key) const { return hash_bits(key); }
  };

  std::vector<std::uint64_t> block_keys_in(const Eigen::AlignedBox3i& voxels) const;

  VoxelGrid grid_;
  MapFrame frame_;
  std::unordered_map<std::uint64_t, Block, BlockHash> blocks_;
  std::size_t leaf_count_ = 0;
  std::shared_ptr<const int> copies_ = std::make_shared<int>(0);  ///< shared by all copies, to count them
};

template <class Items, class KeyOf>
void Octree::own(const Items& items, KeyOf&& key_of) {
  if (copies_.use_count() == 1) return;
  std::uint64_t brick = std::numeric_limits<std::uint64_t>::max();
  for (const auto& item : items) {
    const VoxelKey key = key_of(item);
    if (key.brick() == brick) continue;
    brick = key.brick();
    if (Brick* own_brick = find_brick(key)) own_brick->own();
  }
}

}  // namespace evermap
