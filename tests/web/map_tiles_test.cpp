// SPDX-FileCopyrightText: 2026 the evermap authors
// SPDX-License-Identifier: BSD-3-Clause
#include <map>
#include <random>
#include <set>
#include <support/random_octree.hpp>
#include <tuple>

#include <gtest/gtest.h>

#include <evermap/web/detail/map_tiles.hpp>

namespace evermap {
namespace {

using Place = std::array<int, 3>;

const VoxelGrid kGrid{0.2, Eigen::Vector3d(0, 0, 13107.2)};

int down(int voxel, int level) { return voxel >> level; }

/// The obvious twin: which cells of which tiles hold drawn leaves.
std::map<Place, std::set<Place>> cells_of(const Octree& map, int level) {
  std::map<Place, std::set<Place>> tiles;
  map.for_each_leaf([&](VoxelKey key, const Leaf& leaf) {
    if (!leaf.occupied()) return;
    const Eigen::Vector3i v = key.voxel();
    const Place tile = {down(v.x(), level + 6), down(v.y(), level + 6), down(v.z(), level + 6)};
    tiles[tile].insert({down(v.x(), level), down(v.y(), level), down(v.z(), level)});
  });
  return tiles;
}

Eigen::Vector3d place_of(const TilePoint& point, int level, const Place& tile) {
  const double edge = kGrid.edge * 64 * (1 << level);
  Eigen::Vector3d p = kGrid.origin;
  for (std::size_t i = 0; i < 3; ++i)
    p[static_cast<int>(i)] += edge * (tile[i] + (point.position[i] + 0.5) / 65536);
  return p;
}

TEST(MapTiles, EachLevelDrawsOneLeafOfEachCell) {
  std::mt19937 generator(1);
  const Octree map = random_octree(generator, 4000, kGrid);
  for (const int level : {0, 1, 2, 3, 5, 9}) {
    MapTiles tiles(map);
    for (const auto& [at, cells] : cells_of(map, level)) {
      const std::vector<TilePoint> points = tiles.tile(level, {at[0], at[1], at[2]});
      EXPECT_EQ(points.size(), cells.size()) << "level " << level;
      std::set<Place> drawn;
      for (const TilePoint& point : points) {
        const Eigen::Vector3d p_map = place_of(point, level, at);
        const Eigen::Array3i voxel = ((p_map - kGrid.origin) / kGrid.edge).array().floor().cast<int>();
        drawn.insert({down(voxel.x(), level), down(voxel.y(), level), down(voxel.z(), level)});
      }
      // Leaves on a voxel's border are rounded to either side of it.
      std::size_t known = 0;
      for (const Place& cell : drawn) known += cells.count(cell);
      EXPECT_GE(static_cast<double>(known), 0.97 * static_cast<double>(cells.size())) << "level " << level;
    }
  }
}

TEST(MapTiles, ATileOfTheFinestLevelHasTheLeavesThemselves) {
  Octree map(kGrid);
  const Eigen::Vector3i voxel(-3, 70, 5);
  Leaf& leaf = map.find_or_insert(VoxelKey::from_voxel(voxel));
  leaf.mean_in_voxel = {0.05F, -0.02F, 0.01F};
  leaf.covariance = {1e-3F, 0, 0, 1e-3F, 0, 1e-6F};
  leaf.count = 9;
  leaf.log_odds = 2;
  MapTiles tiles(map, std::nullopt, {{VoxelKey::from_voxel(voxel).bits(), {3, 7}}});
  ASSERT_EQ(tiles.blocks().size(), 1U);
  EXPECT_EQ(tiles.blocks()[0].at, (std::array<std::int32_t, 3>{-1, 1, 0}));
  EXPECT_EQ(tiles.blocks()[0].leaves, 1U);
  const std::vector<TilePoint> points = tiles.tile(0, {-1, 1, 0});
  ASSERT_EQ(points.size(), 1U);
  const Eigen::Vector3d mean = map.gaussian(VoxelKey::from_voxel(voxel), leaf).mean;
  EXPECT_LT((place_of(points[0], 0, {-1, 1, 0}) - mean).norm(), 4e-4);
  EXPECT_EQ(points[0].age.since, 3);
  EXPECT_EQ(points[0].age.seen, 7);
  EXPECT_EQ(std::abs(points[0].normal[2]), 127);
  EXPECT_EQ(points[0].probability, std::lround(255 / (1 + std::exp(-2.0))));
  EXPECT_TRUE(tiles.tile(0, {0, 0, 0}).empty());
  EXPECT_TRUE(tiles.tile(MapTiles::kTopLevel, {1'000'000, 0, 0}).empty());
}

TEST(MapTiles, WhatChangedIsWhatTheComparisonSays) {
  std::mt19937 generator(2);
  const Octree before = random_octree(generator, 3000, kGrid, 60);
  Octree after = before;
  std::vector<VoxelKey> keys;
  before.for_each_leaf([&](VoxelKey key, const Leaf&) { keys.push_back(key); });
  for (std::size_t i = 0; i < keys.size(); i += 3) {
    if (i % 2 == 0) {
      after.erase(keys[i]);
    } else {
      after.find(keys[i])->mean_in_voxel = -after.find(keys[i])->mean_in_voxel;
    }
  }
  const MapDifference difference = compare(before, after);
  MapTiles tiles(after, before);
  std::size_t came = 0;
  std::size_t went = 0;
  std::size_t unchanged = 0;
  for (const TileBlock& block : tiles.blocks()) {
    for (const TilePoint& point : tiles.tile(0, {block.at[0], block.at[1], block.at[2]})) {
      came += point.change == PointChange::kCame;
      went += point.change == PointChange::kWent;
      unchanged += point.change == PointChange::kNone;
    }
  }
  EXPECT_EQ(came, difference.added.size() + difference.moved.size());
  EXPECT_EQ(went, difference.removed.size());
  EXPECT_GT(came, 0U);
  EXPECT_GT(went, 0U);
  EXPECT_GT(unchanged, 0U);
  // A coarse cell shows a change in it before all else.
  std::size_t coarse_changes = 0;
  for (const auto& [at, cells] : cells_of(after, 2)) {
    for (const TilePoint& point : tiles.tile(2, {at[0], at[1], at[2]}))
      coarse_changes += point.change != PointChange::kNone;
  }
  EXPECT_GT(coarse_changes, 0U);
}

TEST(MapTiles, NamesTheBlocksThatAreDrawnDifferently) {
  std::mt19937 generator(3);
  Octree map = random_octree(generator, 2000, kGrid);
  MapTiles tiles(map);
  std::vector<VoxelKey> keys;
  map.for_each_leaf([&](VoxelKey key, const Leaf& leaf) {
    if (leaf.occupied()) keys.push_back(key);
  });
  for (const TileBlock& block : tiles.blocks())
    tiles.tile(2, {block.at[0] >> 2, block.at[1] >> 2, block.at[2] >> 2});
  EXPECT_TRUE(tiles.show(map, 9).empty());
  for (const VoxelKey key : keys) map.find(key)->count += 1;  // seen again, drawn alike
  EXPECT_TRUE(tiles.show(map, 9).empty());
  const VoxelKey moved = keys[keys.size() / 2];
  map.find(moved)->mean_in_voxel.x() += 0.06F;
  std::vector<TileBlock> changed = tiles.show(map, 9);
  ASSERT_EQ(changed.size(), 1U);
  EXPECT_GT(changed[0].revision, 0U);
  const Eigen::Vector3i voxel = moved.voxel();
  EXPECT_EQ(changed[0].at, (std::array<std::int32_t, 3>{voxel.x() >> 6, voxel.y() >> 6, voxel.z() >> 6}));
  map.erase(keys.front());
  map.erase(keys.back());
  changed = tiles.show(map, 9);
  EXPECT_EQ(changed.size(), keys.front().block() == keys.back().block() ? 1U : 2U);
  // What was kept of them is what a new one would make.
  MapTiles fresh(map);
  for (const int level : {0, 1, 2, 4}) {
    for (const auto& [at, cells] : cells_of(map, level)) {
      std::vector<TilePoint> was = tiles.tile(level, {at[0], at[1], at[2]});
      std::vector<TilePoint> is = fresh.tile(level, {at[0], at[1], at[2]});
      ASSERT_EQ(was.size(), is.size());
      for (std::size_t i = 0; i < was.size(); ++i) EXPECT_EQ(was[i].position, is[i].position);
    }
  }
}

}  // namespace
}  // namespace evermap
