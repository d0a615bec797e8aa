// SPDX-FileCopyrightText: 2026 the evermap authors
// SPDX-License-Identifier: BSD-3-Clause
#include <algorithm>
#include <map>
#include <support/random_geometry.hpp>
#include <vector>

#include <gtest/gtest.h>

#include <evermap/map/detail/leaf_finder.hpp>

namespace evermap {
namespace {

using Eigen::Vector3d;
using Eigen::Vector3i;
using test::Random;
using Twin = std::map<VoxelKey, float>;

void expect_equal(const Octree& octree, const Twin& twin) {
  EXPECT_EQ(octree.leaf_count(), twin.size());
  EXPECT_EQ(octree.empty(), twin.empty());
  auto expected = twin.begin();
  octree.for_each_leaf([&](VoxelKey key, const Leaf& leaf) {
    ASSERT_NE(expected, twin.end());
    EXPECT_EQ(key.bits(), expected->first.bits());  // std::map ascends, so must this
    EXPECT_EQ(leaf.log_odds, expected->second);
    ++expected;
  });
  EXPECT_EQ(expected, twin.end());
}

/// Crowded around a few places, so that bricks and blocks fill, empty and neighbour each other.
VoxelKey random_key(Random& random) {
  const int spread = random.chance(0.5) ? 5 : 100;
  const Vector3i place = random.integer(-2, 2) * Vector3i(1000, -VoxelKey::kMaxXY / 3, VoxelKey::kMaxZ / 3);
  return VoxelKey::from_voxel(place + Vector3i(random.integer(-spread, spread),
                                               random.integer(-spread, spread),
                                               random.integer(-spread, spread)));
}

TEST(Octree, BehavesLikeAMap) {
  Random random(1);
  Octree octree(VoxelGrid{0.2});
  Twin twin;
  for (int i = 0; i < 60000; ++i) {
    const bool filling = i / 10000 % 2 == 0;
    // Half of all erasures are of leaves that exist.
    VoxelKey key = random_key(random);
    if (random.chance(0.5)) {
      const auto next = twin.lower_bound(key);
      if (next != twin.end()) key = next->first;
    }
    if (random.chance(filling ? 0.8 : 0.1)) {
      Leaf& leaf = octree.find_or_insert(key);
      EXPECT_EQ(leaf.log_odds, twin[key]);
      leaf.log_odds = twin[key] = static_cast<float>(i);
    } else {
      octree.erase(key);
      twin.erase(key);
    }
    const VoxelKey probe = random_key(random);
    ASSERT_EQ(octree.find(probe) != nullptr, twin.contains(probe));
    if (i % 2003 == 0) expect_equal(octree, twin);
  }
  expect_equal(octree, twin);
}

TEST(LeafFinder, FindsWhatTheOctreeFinds) {
  Random random(3);
  Octree octree(VoxelGrid{0.2});
  std::vector<VoxelKey> keys;
  for (int i = 0; i < 3000; ++i) keys.push_back(random_key(random));
  for (const VoxelKey key : keys) octree.find_or_insert(key);
  for (int i = 0; i < 3000; ++i) keys.push_back(random_key(random));  // most have no leaf
  for (const bool in_order : {false, true}) {
    if (in_order) std::sort(keys.begin(), keys.end());
    LeafFinder leaves(octree);
    LeafFinder const_leaves(std::as_const(octree));
    for (const VoxelKey key : keys) {
      EXPECT_EQ(leaves.find(key), octree.find(key));
      EXPECT_EQ(const_leaves.find(key), octree.find(key));
    }
  }
}

/// A copy stays as it was whatever becomes of the map it was taken of, and the other way round.
TEST(Octree, ACopyIsASnapshot) {
  Random random(5);
  Octree octree(VoxelGrid{0.2});
  std::map<VoxelKey, float> twin;
  std::vector<std::pair<Octree, std::map<VoxelKey, float>>> snapshots;
  const auto content = [](const Octree& map) {
    std::map<VoxelKey, float> leaves;
    map.for_each_leaf([&](VoxelKey key, const Leaf& leaf) { leaves[key] = leaf.log_odds; });
    return leaves;
  };
  for (int i = 0; i < 20000; ++i) {
    const VoxelKey key = random_key(random);
    if (random.chance(0.3)) {
      octree.erase(key);
      twin.erase(key);
    } else {
      octree.find_or_insert(key).log_odds = twin[key] = static_cast<float>(i);
    }
    if (Leaf* leaf = octree.find(random_key(random))) leaf->count = 1;
    if (random.chance(0.001)) snapshots.emplace_back(octree, twin);
    if (!snapshots.empty() && random.chance(0.0005)) {  // a map of its own, changed in its turn
      auto& [map, leaves] =
          snapshots[static_cast<std::size_t>(random.integer(0, static_cast<int>(snapshots.size()) - 1))];
      for (auto& [changed, log_odds] : leaves) map.find(changed)->log_odds = log_odds = -1;
    }
    if (random.chance(0.0005)) snapshots.clear();
  }
  EXPECT_EQ(content(octree), twin);
  EXPECT_GT(snapshots.size(), 1U);
  for (const auto& [map, leaves] : snapshots) EXPECT_EQ(content(map), leaves);
}

TEST(Octree, OwnedLeavesAreNotSharedWithCopies) {
  Random random(6);
  Octree octree(VoxelGrid{0.2});
  std::vector<VoxelKey> keys;
  for (int i = 0; i < 500; ++i) keys.push_back(random_key(random));
  std::sort(keys.begin(), keys.end());
  for (const VoxelKey key : keys) octree.find_or_insert(key);
  const Octree copy = octree;
  octree.own(keys, [](VoxelKey key) { return key; });
  for (const VoxelKey key : keys) {
    const Leaf* own = std::as_const(octree).find(key);
    EXPECT_NE(own, copy.find(key));
    EXPECT_EQ(own, octree.find(key));  // finding it for a change moves nothing any more
  }
}

TEST(Octree, EmptyNodesVanish) {
  Random random(2);
  Octree octree(VoxelGrid{0.2});
  std::vector<VoxelKey> keys;
  for (int i = 0; i < 2000; ++i) keys.push_back(random_key(random));
  for (const VoxelKey key : keys) octree.find_or_insert(key);
  const std::size_t full = octree.memory_bytes();
  for (const VoxelKey key : keys) {
    octree.erase(key);
    EXPECT_EQ(octree.find(key), nullptr);
    // Neither an empty block nor an empty brick stays behind.
    const Octree::Block* block = octree.find_block(key.block());
    if (block == nullptr) continue;
    EXPECT_FALSE(block->empty());
    const Brick* brick = block->find(key.brick_in_block());
    EXPECT_FALSE(brick != nullptr && brick->empty());
  }
  for (const VoxelKey key : keys) EXPECT_EQ(octree.find_block(key.block()), nullptr);
  EXPECT_TRUE(octree.empty());
  EXPECT_LT(octree.memory_bytes(), full / 10);
  octree.for_each_leaf([](VoxelKey, const Leaf&) { FAIL() << "a leaf in an empty octree"; });
}

TEST(Octree, MemoryCountsEveryLeaf) {
  Octree octree(VoxelGrid{0.2});
  for (int i = 0; i < 512; ++i) octree.find_or_insert(VoxelKey(static_cast<std::uint64_t>(i)));
  EXPECT_GE(octree.memory_bytes(), 512 * sizeof(Leaf));
  EXPECT_LE(octree.memory_bytes(), 3 * 512 * sizeof(Leaf));
}

TEST(Octree, CopiesAreIndependent) {
  Octree octree(VoxelGrid{0.2});
  const VoxelKey key = VoxelKey::from_voxel({1, 2, 3});
  octree.find_or_insert(key).log_odds = 1;
  Octree copy = octree;
  copy.find(key)->log_odds = 2;
  copy.find_or_insert(VoxelKey::from_voxel({9, 9, 9}));
  EXPECT_EQ(octree.find(key)->log_odds, 1);
  EXPECT_EQ(octree.leaf_count(), 1U);
  EXPECT_EQ(copy.leaf_count(), 2U);
}

TEST(Leaf, KeepsItsGaussianFarFromTheOrigin) {
  Random random(3);
  for (const Vector3d& place : {Vector3d(0, 0, 0), Vector3d(5e6, -4e5, 300)}) {
    Octree octree(VoxelGrid::around(place, 0.2));
    for (int i = 0; i < 1000; ++i) {
      const Gaussian surface{place + random.in_cube(10), random.covariance(0.002, 0.1),
                             random.log_uniform(1, 1000)};
      const VoxelKey key = *octree.grid().key(surface.mean);
      Leaf& leaf = octree.find_or_insert(key);
      leaf.set_gaussian(surface, octree.grid().center(key));
      const Gaussian found = octree.gaussian(key, leaf);
      EXPECT_LE((found.mean - surface.mean).norm(), 2e-8);
      EXPECT_LE((found.covariance - surface.covariance).cwiseAbs().maxCoeff(),
                1e-7 * surface.covariance.trace());
      EXPECT_EQ(found.covariance, found.covariance.transpose());
      EXPECT_NEAR(found.count / surface.count, 1, 1e-7);
    }
  }
}

TEST(Leaf, IsOccupiedAboveEvenOdds) {
  Leaf leaf;
  EXPECT_FALSE(leaf.occupied());
  leaf.log_odds = 1e-6F;
  EXPECT_TRUE(leaf.occupied());
  leaf.log_odds = -1;
  EXPECT_FALSE(leaf.occupied());
}

}  // namespace
}  // namespace evermap
