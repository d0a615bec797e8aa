// SPDX-FileCopyrightText: 2026 the evermap authors
// SPDX-License-Identifier: BSD-3-Clause
#include <gtest/gtest.h>

#include <evermap/map/map_difference.hpp>

namespace evermap {
namespace {

constexpr double kEdge = 0.4;
const VoxelKey kHere = VoxelKey::from_voxel({1, 2, 3});
const VoxelKey kThere = VoxelKey::from_voxel({-100, 2, 3});

Octree map_with(VoxelKey key, float log_odds, float x = 0) {
  Octree octree(VoxelGrid{kEdge});
  Leaf& leaf = octree.find_or_insert(key);
  leaf.log_odds = log_odds;
  leaf.count = 1;
  leaf.mean_in_voxel.x() = x;
  return octree;
}

void expect_difference(const MapDifference& difference, const std::vector<VoxelKey>& added,
                       const std::vector<VoxelKey>& removed, const std::vector<VoxelKey>& moved) {
  EXPECT_EQ(difference.added, added);
  EXPECT_EQ(difference.removed, removed);
  EXPECT_EQ(difference.moved, moved);
}

TEST(MapDifference, EqualMapsDoNotDiffer) {
  expect_difference(compare(map_with(kHere, 1), map_with(kHere, 1)), {}, {}, {});
  expect_difference(compare(Octree(VoxelGrid{kEdge}), Octree(VoxelGrid{kEdge})), {}, {}, {});
}

TEST(MapDifference, LeavesComeAndGo) {
  expect_difference(compare(map_with(kHere, 1), map_with(kThere, 1)), {kThere}, {kHere}, {});
}

TEST(MapDifference, PendingLeavesAreNotThere) {
  expect_difference(compare(map_with(kHere, 1), map_with(kHere, -1)), {}, {kHere}, {});
  expect_difference(compare(map_with(kHere, -1), map_with(kHere, 1)), {kHere}, {}, {});
  expect_difference(compare(map_with(kHere, -1), map_with(kHere, 0)), {}, {}, {});
}

// These leaves have no extent of their own: the limit is sqrt(chi2) times a sixteenth of the edge, 0.0842 m.
TEST(MapDifference, AMeanMovesOutOfItsLeaf) {
  expect_difference(compare(map_with(kHere, 1), map_with(kHere, 2, 0.084F)), {}, {}, {});
  expect_difference(compare(map_with(kHere, 1), map_with(kHere, 2, 0.085F)), {}, {}, {kHere});
  expect_difference(compare(map_with(kHere, 1, 0.1F), map_with(kHere, 1)), {}, {}, {kHere});
}

TEST(MapDifference, SurfaceThatNoiseCarriedAcrossABorderIsNoChange) {
  const VoxelKey beside = VoxelKey::from_voxel({2, 2, 3});
  const Octree before = map_with(kHere, 1, 0.19F);
  const MapDifference across = compare(before, map_with(beside, 1, -0.19F));
  expect_difference(across, {}, {}, {});
  EXPECT_EQ(across.border_added, 1U);
  EXPECT_EQ(across.border_removed, 1U);
  expect_difference(compare(before, map_with(beside, 1, -0.1F)), {beside}, {kHere}, {});
}

TEST(MapDifference, ListsAscend) {
  Octree before(VoxelGrid{kEdge});
  Octree after(VoxelGrid{kEdge});
  for (int i = 0; i < 200; ++i) {
    Leaf& leaf =
        (i % 2 ? before : after).find_or_insert(VoxelKey::from_voxel({(i * 77) % 1000 - 500, i, -i}));
    leaf.log_odds = 1;
  }
  const MapDifference difference = compare(before, after);
  EXPECT_EQ(difference.added.size(), 100U);
  EXPECT_EQ(difference.removed.size(), 100U);
  EXPECT_TRUE(std::is_sorted(difference.added.begin(), difference.added.end()));
  EXPECT_TRUE(std::is_sorted(difference.removed.begin(), difference.removed.end()));
}

}  // namespace
}  // namespace evermap
