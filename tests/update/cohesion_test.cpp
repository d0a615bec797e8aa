// SPDX-FileCopyrightText: 2026 the evermap authors
// SPDX-License-Identifier: BSD-3-Clause
#include <algorithm>

#include <gtest/gtest.h>

#include <evermap/update/detail/map_updater.hpp>

namespace evermap {
namespace {

using Eigen::Vector3i;

/// A horizontal plate of 9 x 9 leaves at height 0, known from a survey.
class CohesionTest : public ::testing::Test {
 protected:
  CohesionTest() {
    for (int x = 0; x < 9; ++x)
      for (int y = 0; y < 9; ++y) put({x, y, 0});
  }
  static VoxelKey key(const Vector3i& voxel) { return VoxelKey::from_voxel(voxel); }
  void put(const Vector3i& voxel) {
    Gaussian surface;
    surface.mean = octree_.grid().center(voxel);
    surface.covariance = Eigen::Vector3d(3e-3, 3e-3, 1e-4).asDiagonal();
    surface.count = 50;
    Leaf& leaf = octree_.find_or_insert(key(voxel));
    leaf.set_gaussian(surface, octree_.grid().center(voxel));
    leaf.log_odds = 3;
  }
  /// A scan by a sensor 1 m above the plate contradicts these leaves, which go at once.
  LeafChanges let_go(const std::vector<Vector3i>& voxels, const UpdateParameters& parameters = {}) {
    BundleGrid bundles;
    bundles.origin_map = {0.9, 0.9, 1.1};
    Evidence evidence;
    for (const Vector3i& voxel : voxels) evidence.leaves.push_back({key(voxel), 1, 0, 0});
    std::sort(evidence.leaves.begin(), evidence.leaves.end(),
              [](const LeafEvidence& a, const LeafEvidence& b) { return a.leaf < b.leaf; });
    for (const LeafEvidence& against : evidence.leaves) octree_.find(against.leaf)->log_odds = 0.1F;
    return apply(octree_, bundles, evidence, parameters, 1, &rollback_);
  }

  Octree octree_{VoxelGrid{.edge = 0.2}};
  Rollback rollback_{1};
};

TEST_F(CohesionTest, ALeafGoesWithThoseAroundIt) {
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

TEST_F(CohesionTest, ATearDoesNotRun) {
  std::vector<Vector3i> rows;
  for (int x = 0; x < 2; ++x)
    for (int y = 0; y < 9; ++y) rows.emplace_back(x, y, 0);
  EXPECT_EQ(let_go(rows).erased, rows.size());
}

TEST_F(CohesionTest, WhatStoodBeforeASurfaceSaysNothingOfIt) {
  std::vector<Vector3i> box;
  for (int x = 2; x < 7; ++x)
    for (int y = 2; y < 7; ++y) box.emplace_back(x, y, 1);
  for (const Vector3i& voxel : box) put(voxel);
  EXPECT_EQ(let_go(box).erased, box.size());
  EXPECT_EQ(octree_.find(key({4, 4, 0}))->log_odds, 3);
}

TEST_F(CohesionTest, ThePaperKnowsNothingOfIt) {
  std::vector<Vector3i> most;
  for (int x = 0; x < 9; ++x)
    for (int y = 0; y < 9; ++y)
      if (x != 4 || y != 4) most.emplace_back(x, y, 0);
  EXPECT_EQ(let_go(most, UpdateParameters::paper()).erased, most.size());
}

}  // namespace
}  // namespace evermap
