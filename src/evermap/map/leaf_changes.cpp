// SPDX-FileCopyrightText: 2026 the evermap authors
// SPDX-License-Identifier: BSD-3-Clause
#include <algorithm>
#include <cstring>

#include <evermap/map/detail/leaf_changes.hpp>

namespace evermap {
namespace {

// Every bit counts: a map that is made of changes must be the map that was.
bool is_same(const Leaf& a, const Leaf& b) {
  static_assert(sizeof(Leaf) == 11 * sizeof(float), "no padding");
  return std::memcmp(static_cast<const void*>(&a), static_cast<const void*>(&b), sizeof(Leaf)) == 0;
}

template <class Node>
const Node& node_or_empty(const Node* node) {
  static const Node kEmpty;
  return node != nullptr ? *node : kEmpty;
}

}  // namespace

std::vector<LeafChange> changes_between(const Octree& before, const Octree& after) {
  std::vector<LeafChange> changes;
  std::vector<std::uint64_t> blocks = before.block_keys();
  const std::vector<std::uint64_t> others = after.block_keys();
  blocks.insert(blocks.end(), others.begin(), others.end());
  std::sort(blocks.begin(), blocks.end());
  blocks.erase(std::unique(blocks.begin(), blocks.end()), blocks.end());
  for (const std::uint64_t block : blocks) {
    const VoxelKey first_of_block = VoxelKey::first_of_block(block);
    Octree::Block::for_each_pair(
        node_or_empty(before.find_block(block)), node_or_empty(after.find_block(block)),
        [&](int brick, const Brick* old_brick, const Brick* new_brick) {
          const VoxelKey first = first_of_block.first_of_brick(brick);
          Brick::for_each_pair(
              node_or_empty(old_brick), node_or_empty(new_brick),
              [&](int voxel, const Leaf* old_leaf, const Leaf* new_leaf) {
                if (old_leaf != nullptr && new_leaf != nullptr && is_same(*old_leaf, *new_leaf)) return;
                changes.push_back({first.with_voxel(voxel), new_leaf != nullptr ? *new_leaf : Leaf{}});
              });
        });
  }
  return changes;
}

void apply_changes(std::span<const LeafChange> changes, Octree& octree) {
  octree.own(changes, [](const LeafChange& change) { return change.key; });
  for (const LeafChange& change : changes) {
    if (change.is_removed()) {
      octree.erase(change.key);
    } else {
      octree.find_or_insert(change.key) = change.leaf;
    }
  }
}

}  // namespace evermap
