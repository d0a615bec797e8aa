// SPDX-FileCopyrightText: 2026 the evermap authors
// SPDX-License-Identifier: BSD-3-Clause
#include <algorithm>

#include <gtest/gtest.h>

#include <evermap/update/detail/map_updater.hpp>

namespace evermap {
namespace {

using Eigen::Vector3i;

/// A horizontal plate of 9 x 9 leaves at height 0, known from a survey.
class SurfaceRegionsTest : public ::testing::Test {
 protected:
  SurfaceRegionsTest() {
    for (int x = 0; x < 9; ++x)
      for (int y = 0; y < 9; ++y) put({x, y, 0});
  }
  static VoxelKey key(const Vector3i& voxel) { return VoxelKey::from_voxel(voxel); }
  void put(const Vector3i& voxel, const Eigen::Vector3d& variances = {3e-3, 3e-3, 1e-4}, float log_odds = 3) {
    Gaussian surface;
    surface.mean = octree_.grid().center(voxel);
    surface.covariance = variances.asDiagonal();
    surface.count = 50;
    Leaf& leaf = octree_.find_or_insert(key(voxel));
    leaf.set_gaussian(surface, octree_.grid().center(voxel));
    leaf.log_odds = log_odds;
  }
  /// A scan by a sensor above and beside the plate contradicts these leaves, which go at once.
  LeafChanges let_go(const std::vector<Vector3i>& voxels, const UpdateParameters& parameters = {}) {
    BundleGrid bundles;
    bundles.origin_map = {3, 0.9, 1.1};
    Evidence evidence;
    for (const Vector3i& voxel : voxels) evidence.leaves.push_back({key(voxel), 1, 0, 0});
    std::sort(evidence.leaves.begin(), evidence.leaves.end(),
              [](const LeafEvidence& a, const LeafEvidence& b) { return a.leaf < b.leaf; });
    for (const LeafEvidence& against : evidence.leaves) octree_.find(against.leaf)->log_odds = 0.1F;
    return apply(octree_, bundles, evidence, parameters, 1, &rollback_, &gone_);
  }

  Octree octree_{VoxelGrid{.edge = 0.2}};
  Rollback rollback_{1};
  GoneLeaves gone_;
};

TEST_F(SurfaceRegionsTest, ARegionGoesWithItsRim) {
  std::vector<Vector3i> around;
  for (int x = 3; x <= 5; ++x)
    for (int y = 3; y <= 5; ++y)
      if (x != 4 || y != 4) around.emplace_back(x, y, 0);
  rollback_.begin_scan();
  const Octree before = octree_;
  EXPECT_EQ(let_go(around).erased, 9U);
  EXPECT_EQ(octree_.find(key({4, 4, 0})), nullptr);
  EXPECT_EQ(octree_.leaf_count(), before.leaf_count() - 9);
  rollback_.roll_back(octree_);
  EXPECT_EQ(octree_.leaf_count(), before.leaf_count());
  EXPECT_EQ(octree_.find(key({4, 4, 0}))->log_odds, 3);
  EXPECT_EQ(octree_.find(key({2, 2, 0}))->log_odds, 3);
}

TEST_F(SurfaceRegionsTest, ATearDoesNotRun) {
  std::vector<Vector3i> rows;
  for (int x = 0; x < 2; ++x)
    for (int y = 0; y < 9; ++y) rows.emplace_back(x, y, 0);
  EXPECT_EQ(let_go(rows).erased, rows.size());
}

TEST_F(SurfaceRegionsTest, WhatStoodBeforeASurfaceSaysNothingOfIt) {
  std::vector<Vector3i> box;
  for (int x = 2; x < 7; ++x)
    for (int y = 2; y < 7; ++y) box.emplace_back(x, y, 1);
  for (const Vector3i& voxel : box) put(voxel);
  EXPECT_EQ(let_go(box).erased, box.size());
  EXPECT_EQ(octree_.find(key({4, 4, 0}))->log_odds, 3);
}

TEST_F(SurfaceRegionsTest, ARimMayGoInSeveralScans) {
  std::vector<Vector3i> first, second;
  for (int i = 0; i < 9; ++i) {
    first.emplace_back(i, 0, 0);
    second.emplace_back(i, 8, 0);
    if (i > 0 && i < 8) second.emplace_back(0, i, 0);
  }
  EXPECT_EQ(let_go(first).erased, first.size());
  EXPECT_EQ(let_go(second).erased, second.size() + 8 * 7);
  EXPECT_EQ(octree_.leaf_count(), 0U);
}

/// The plate's rim but for the side at x = 8.
std::vector<Vector3i> three_sides() {
  std::vector<Vector3i> sides;
  for (int i = 0; i < 9; ++i) {
    sides.emplace_back(i, 0, 0);
    sides.emplace_back(i, 8, 0);
    if (i > 0 && i < 8) sides.emplace_back(0, i, 0);
  }
  return sides;
}

TEST_F(SurfaceRegionsTest, WhatStillStandsHoldsARegion) {
  for (int i = 0; i < 9; ++i) put({9, i, 0}, {1e-4, 3e-3, 3e-3}, 5);  // seen since it was surveyed
  const std::vector<Vector3i> sides = three_sides();
  EXPECT_EQ(let_go(sides).erased, sides.size());
  EXPECT_NE(octree_.find(key({4, 4, 0})), nullptr);
}

TEST_F(SurfaceRegionsTest, WhatNobodySawSinceHoldsNothing) {
  for (int i = 0; i < 9; ++i) put({9, i, 0}, {1e-4, 3e-3, 3e-3});
  const std::vector<Vector3i> sides = three_sides();
  EXPECT_GE(let_go(sides).erased, sides.size() + 8 * 7);
  EXPECT_EQ(octree_.find(key({4, 4, 0})), nullptr);
}

TEST_F(SurfaceRegionsTest, ThePaperKnowsNothingOfIt) {
  std::vector<Vector3i> most;
  for (int x = 0; x < 9; ++x)
    for (int y = 0; y < 9; ++y)
      if (x != 4 || y != 4) most.emplace_back(x, y, 0);
  EXPECT_EQ(let_go(most, UpdateParameters::paper()).erased, most.size());
}

}  // namespace
}  // namespace evermap
