// SPDX-FileCopyrightText: 2026 the evermap authors
// SPDX-License-Identifier: BSD-3-Clause
#include <gtest/gtest.h>

#include <evermap/evaluation/octomap_baseline.hpp>

namespace evermap {
namespace {

constexpr double kVoxelEdge = 0.2;

/// A wall across x, points in the middle of leaves.
Points wall(double x) {
  Points points;
  for (int y = -5; y < 5; ++y) {
    for (int z = 0; z < 5; ++z) points.emplace_back(x, 0.1 + 0.2 * y, 0.1 + 0.2 * z);
  }
  return points;
}

TEST(OctoMapBaseline, KnowsTheSurfaceItWasGiven) {
  OctoMapBaseline map(kVoxelEdge);
  EXPECT_FALSE(map.occupied({4.1, 0.1, 0.1}));
  map.insert_surface(wall(4.1));
  for (const auto& p : wall(4.1)) EXPECT_TRUE(map.occupied(p));
  EXPECT_FALSE(map.occupied({4.5, 0.1, 0.1}));
  EXPECT_EQ(map.occupied_centers().size(), wall(4.1).size());
}

TEST(OctoMapBaseline, AScanMarksItsEndsAndNothingElse) {
  OctoMapBaseline map(kVoxelEdge);
  map.insert_scan({0.1, 0.1, 0.5}, wall(4.1), -1);
  for (const auto& p : wall(4.1)) EXPECT_TRUE(map.occupied(p));
  EXPECT_EQ(map.occupied_centers().size(), wall(4.1).size());
  EXPECT_FALSE(map.occupied({2.1, 0.1, 0.5}));
}

TEST(OctoMapBaseline, ScansClearWhatTheySeeThrough) {
  OctoMapBaseline map(kVoxelEdge);
  map.insert_surface(wall(2.1));
  const Eigen::Vector3d seen_through(2.1, 0.1, 0.5);
  int scans = 0;
  while (map.occupied(seen_through) && scans < 100) {
    map.insert_scan({0.1, 0.1, 0.5}, {{4.1, 0.1, 0.5}}, -1);
    ++scans;
  }
  // From the clamping maximum of 3.5 a miss of -0.405 takes nine scans to fall below zero.
  EXPECT_EQ(scans, 9);
  EXPECT_TRUE(map.occupied({2.1, 0.1, 0.1})) << "no ray went through it";
}

TEST(OctoMapBaseline, RaysBeyondTheMaximumRangeMarkNothing) {
  OctoMapBaseline map(kVoxelEdge);
  map.insert_surface({{2.1, 0.1, 0.5}});
  for (int i = 0; i < 20; ++i) map.insert_scan({0.1, 0.1, 0.5}, {{4.1, 0.1, 0.5}}, 3);
  EXPECT_FALSE(map.occupied({2.1, 0.1, 0.5}));
  EXPECT_TRUE(map.occupied_centers().empty());
}

TEST(OctoMapBaseline, CentersStandForEveryLeafOfAPrunedCube) {
  OctoMapBaseline map(kVoxelEdge);
  Points cube;
  for (int i = 0; i < 64; ++i)
    cube.emplace_back(0.1 + 0.2 * (i % 4), 0.1 + 0.2 * (i / 4 % 4), 0.1 + 0.2 * (i / 16));
  map.insert_surface(cube);
  const auto centers = map.occupied_centers();
  ASSERT_EQ(centers.size(), cube.size());
  for (const auto& p : cube) {
    const auto is_p = [&](const Eigen::Vector3d& center) { return (center - p).norm() < 1e-6; };
    EXPECT_EQ(std::count_if(centers.begin(), centers.end(), is_p), 1);
  }
}

TEST(OctoMapBaseline, GrowsInMemoryAndNamesItsVersion) {
  OctoMapBaseline map(kVoxelEdge);
  const std::size_t empty = map.memory_bytes();
  map.insert_surface(wall(4.1));
  EXPECT_GT(map.memory_bytes(), empty);
  EXPECT_EQ(OctoMapBaseline::version().substr(0, 2), "1.");
}

}  // namespace
}  // namespace evermap
