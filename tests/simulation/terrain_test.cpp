// SPDX-FileCopyrightText: 2026 the evermap authors
// SPDX-License-Identifier: BSD-3-Clause
#include <cmath>
#include <limits>
#include <numbers>

#include <gtest/gtest.h>

#include <evermap/simulation/terrain.hpp>

namespace evermap {
namespace {

TEST(Terrain, ASlopeRisesAlongBothAxes) { EXPECT_NEAR(slope({0.1, -0.2})(3, 4), -0.5, 1e-12); }

TEST(Terrain, WavesRepeatAfterTheirLength) {
  const HeightFunction height = waves({2, {10, 6}, 0.3});
  EXPECT_NEAR(height(0, 0), 2 * std::sin(0.3), 1e-12);
  EXPECT_NEAR(height(1.2, 0.7), height(11.2, 6.7), 1e-12);
  EXPECT_NEAR(height(1.2, 0), -height(1.2, 3), 1e-12);
  const HeightFunction ridges = waves({2, {10, std::numeric_limits<double>::infinity()}, 0});
  EXPECT_NEAR(ridges(2.5, 77), 2, 1e-12);
}

TEST(Terrain, RoughnessStaysInItsBoundsAndUsesThem) {
  const HeightFunction height = roughness({0.3, 1.5, 4});
  double lowest = 0;
  double highest = 0;
  for (double x = -20; x < 20; x += 0.31) {
    for (double y = -20; y < 20; y += 0.29) {
      lowest = std::min(lowest, height(x, y));
      highest = std::max(highest, height(x, y));
      ASSERT_LT(std::abs(height(x + 1e-6, y) - height(x, y)), 1e-5) << "a step";
    }
  }
  EXPECT_GE(lowest, -0.3);
  EXPECT_LE(highest, 0.3);
  EXPECT_GT(highest - lowest, 0.4);
}

TEST(Terrain, RoughnessDependsOnItsSeedAlone) {
  EXPECT_EQ(roughness({1, 2, 4})(3.3, -5.1), roughness({1, 2, 4})(3.3, -5.1));
  EXPECT_NE(roughness({1, 2, 4})(3.3, -5.1), roughness({1, 2, 5})(3.3, -5.1));
}

TEST(Terrain, TerracesRiseBenchByBench) {
  const HeightFunction height = terraces({{10, 0}, {40, 20}, 5, 3, 6, 2, 8});
  EXPECT_EQ(height(10, 0), 0);
  EXPECT_EQ(height(29.9, 0), 0);
  EXPECT_NEAR(height(31, 0), 3, 1e-9) << "half up the first face";
  EXPECT_NEAR(height(33, 0), 6, 1e-9) << "on the first bench";
  EXPECT_NEAR(height(39, 0), 6, 1e-9);
  EXPECT_NEAR(height(41, 0), 9, 1e-9);
  EXPECT_NEAR(height(100, 0), 18, 1e-9) << "on top";
  EXPECT_NEAR(height(10, 11), 3, 1e-9) << "the other side";
}

TEST(Terrain, AnEmbankmentFollowsItsLine) {
  const HeightFunction height = embankment({{{0, 0}, {10, 0}, {10, 10}}, 2, 4, 3});
  EXPECT_NEAR(height(5, 0), 2, 1e-12);
  EXPECT_NEAR(height(5, 1.9), 2, 1e-12);
  EXPECT_NEAR(height(5, -3.5), 1, 1e-12) << "half down its side";
  EXPECT_NEAR(height(5, -5), 0, 1e-12);
  EXPECT_NEAR(height(10, 7), 2, 1e-12);
}

TEST(Terrain, FeaturesAddUp) {
  EXPECT_NEAR(sum({slope({1, 0}), slope({0, 2})})(3, 4), 11, 1e-12);
  EXPECT_EQ(sum({})(3, 4), 0);
}

TEST(StandingPose, LeansWithTheGround) {
  const HeightFunction ground = slope({0.1, 0.05});
  const Pose T_map_stand = standing_pose(ground, {{4, 2}, std::numbers::pi / 2}, 1.5);
  EXPECT_TRUE(is_rotation(T_map_stand.rotation, 1e-12));
  EXPECT_TRUE(T_map_stand.translation.isApprox(Eigen::Vector3d(4, 2, 0.5)));
  EXPECT_TRUE(T_map_stand.rotation.col(2).isApprox(Eigen::Vector3d(-0.1, -0.05, 1).normalized()));
  EXPECT_TRUE(T_map_stand.rotation.col(0).isApprox(Eigen::Vector3d(0, 1, 0.05).normalized()));
}

}  // namespace
}  // namespace evermap
