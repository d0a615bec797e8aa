// SPDX-FileCopyrightText: 2026 the evermap authors
// SPDX-License-Identifier: BSD-3-Clause
#include <map>
#include <random>
#include <support/random_octree.hpp>

#include <gtest/gtest.h>

#include <evermap/map/detail/leaf_changes.hpp>

namespace evermap {
namespace {

using Leaves = std::map<std::uint64_t, Leaf>;

Leaves leaves_of(const Octree& octree) {
  Leaves leaves;
  octree.for_each_leaf([&](VoxelKey key, const Leaf& leaf) { leaves[key.bits()] = leaf; });
  return leaves;
}

bool is_same(const Leaf& a, const Leaf& b) {
  return a.mean_in_voxel == b.mean_in_voxel && a.covariance == b.covariance && a.count == b.count &&
         a.log_odds == b.log_odds;
}

/// Leaf by leaf, without a look at what is shared.
std::size_t count_changes(const Octree& before, const Octree& after) {
  const Leaves old_leaves = leaves_of(before);
  const Leaves new_leaves = leaves_of(after);
  std::size_t count = 0;
  for (const auto& [key, leaf] : old_leaves) count += new_leaves.contains(key) ? 0 : 1;
  for (const auto& [key, leaf] : new_leaves) {
    const auto old_leaf = old_leaves.find(key);
    count += old_leaf == old_leaves.end() || !is_same(old_leaf->second, leaf) ? 1 : 0;
  }
  return count;
}

void expect_same(const Octree& a, const Octree& b) {
  EXPECT_EQ(a.leaf_count(), b.leaf_count());
  EXPECT_EQ(count_changes(a, b), 0U);
}

/// Changes, removes and adds some leaves.
void change(Octree& octree, std::mt19937& generator, int count) {
  const Leaves leaves = leaves_of(octree);
  std::uniform_int_distribution<std::size_t> any(0, leaves.size() - 1);
  for (int i = 0; i < count; ++i) {
    const VoxelKey key(std::next(leaves.begin(), static_cast<std::ptrdiff_t>(any(generator)))->first);
    if (i % 3 == 0) {
      octree.erase(key);
    } else {
      octree.find_or_insert(VoxelKey::from_voxel(key.voxel() + Eigen::Vector3i(i % 2, 0, 0))).count = 7;
    }
  }
}

TEST(LeafChanges, MakeOneMapTheOther) {
  std::mt19937 generator(1);
  for (int trial = 0; trial < 30; ++trial) {
    const VoxelGrid grid{.edge = 0.2};
    const Octree before = random_octree(generator, trial * 20, grid);
    const Octree after = random_octree(generator, trial * 15, grid);
    const std::vector<LeafChange> changes = changes_between(before, after);
    EXPECT_EQ(changes.size(), count_changes(before, after));
    EXPECT_TRUE(std::is_sorted(changes.begin(), changes.end(),
                               [](const LeafChange& a, const LeafChange& b) { return a.key < b.key; }));
    Octree made = before;
    apply_changes(changes, made);
    expect_same(made, after);
  }
}

TEST(LeafChanges, BetweenSnapshotsAreThoseOfLeaves) {
  std::mt19937 generator(2);
  Octree octree = random_octree(generator, 3000, VoxelGrid{.edge = 0.2});
  for (int trial = 0; trial < 30; ++trial) {
    const Octree before = octree;
    change(octree, generator, trial);
    const std::vector<LeafChange> changes = changes_between(before, octree);
    EXPECT_EQ(changes.size(), count_changes(before, octree));
    Octree made = before;
    apply_changes(changes, made);
    expect_same(made, octree);
  }
}

TEST(LeafChanges, ASnapshotHasNone) {
  std::mt19937 generator(3);
  const Octree octree = random_octree(generator, 3000, VoxelGrid{.edge = 0.2});
  const Octree copy = octree;
  EXPECT_TRUE(changes_between(octree, copy).empty());
}

}  // namespace
}  // namespace evermap
