// SPDX-FileCopyrightText: 2026 the evermap authors
// SPDX-License-Identifier: BSD-3-Clause
#include <algorithm>
#include <cmath>

#include <gtest/gtest.h>

#include <evermap/simulation/change_truth.hpp>

namespace evermap {
namespace {

constexpr double kSpacing = 0.05;
constexpr double kChanged = 0.1;

double flat(double, double) { return 0; }

Scene ground() {
  Scene scene;
  add_ground(scene, 0, {Eigen::Vector2d(-4, -4), Eigen::Vector2d(4, 4)}, 0.5, flat);
  return scene;
}

/// Ground with a box of 2 m x 2 m, its top at 1 m, sunk by 0.3 m.
Scene with_box(double x) {
  Scene scene = ground();
  Pose T_map_box;
  T_map_box.translation = {x, 0, 0.35};
  add_box(scene, 1, T_map_box, {2, 2, 1.3});
  return scene;
}

bool in_footprint(const Eigen::Vector3d& p) { return std::max(std::abs(p.x()), std::abs(p.y())) < 1; }

double count(double area) { return area / (kSpacing * kSpacing); }

TEST(ChangeTruth, OfTheSameWorldIsNoChange) {
  const ChangeTruth truth = change_truth(with_box(0), with_box(0), kSpacing, kChanged);
  EXPECT_EQ(truth.unchanged.size(), truth.now.size());
  EXPECT_NEAR(static_cast<double>(truth.now.size()), count(64 - 4 + 4 + 8), 300);
  EXPECT_TRUE(truth.removed.empty());
  EXPECT_TRUE(truth.added.empty());
}

TEST(ChangeTruth, AVanishedBoxIsRemovedAndUncoversTheGround) {
  const ChangeTruth truth = change_truth(with_box(0), ground(), kSpacing, kChanged);
  // Its sides count from 0.1 m above the ground.
  EXPECT_NEAR(static_cast<double>(truth.removed.size()), count(4 + 8 * 0.9), 300);
  for (const auto& p : truth.removed) EXPECT_GT(p.z(), kChanged);
  EXPECT_NEAR(static_cast<double>(truth.unchanged.size()), count(64 - 4), 300);
  EXPECT_NEAR(static_cast<double>(truth.added.size()), count(1.8 * 1.8), 50);
  for (const auto& p : truth.added) EXPECT_TRUE(in_footprint(p) && p.z() == 0) << p.transpose();
}

TEST(ChangeTruth, ANewBoxIsAddedAndTheGroundUnderItIsInNoList) {
  const ChangeTruth truth = change_truth(ground(), with_box(0), kSpacing, kChanged);
  EXPECT_TRUE(truth.removed.empty());
  for (const auto& p : truth.unchanged) EXPECT_FALSE(in_footprint(p)) << p.transpose();
  EXPECT_NEAR(static_cast<double>(truth.unchanged.size()), count(64 - 4), 300);
  EXPECT_NEAR(static_cast<double>(truth.added.size()), count(4 + 8 * 0.9), 300);
}

TEST(ChangeTruth, OfAMovedBoxOneEndIsRemovedAndOneAdded) {
  const ChangeTruth truth = change_truth(with_box(0), with_box(0.25), kSpacing, kChanged);
  ASSERT_FALSE(truth.removed.empty());
  for (const auto& p : truth.removed) {
    EXPECT_LT(p.x(), -0.75 - kChanged + 1e-9);
    EXPECT_GT(p.z(), kChanged);
  }
  const auto on_old_end =
      std::count_if(truth.removed.begin(), truth.removed.end(), [](const auto& p) { return p.x() < -0.999; });
  EXPECT_NEAR(static_cast<double>(on_old_end), count(2 * 0.9), 100);
  // New surface in front; at the back the new end, inside the box before, and the ground that it left.
  for (const auto& p : truth.added) {
    EXPECT_TRUE(p.x() > 1 + kChanged - 1e-9 || p.x() < -0.75 + 1e-9) << p.transpose();
  }
  const auto on_ground =
      std::count_if(truth.added.begin(), truth.added.end(), [](const auto& p) { return p.z() == 0; });
  EXPECT_NEAR(static_cast<double>(on_ground), count(0.15 * 1.8), 50);
  EXPECT_GT(truth.added.size(), static_cast<std::size_t>(count(4 * 0.9)));
}

TEST(ChangeTruth, OldSurfaceInsideAGrownHeapIsNotRemoved) {
  Scene before = ground();
  Scene now = ground();
  add_heap(before, 1, {{0, 0}, 2, 0.8}, flat);
  add_heap(now, 1, {{0, 0}, 3, 1.4}, flat);
  const ChangeTruth grown = change_truth(before, now, kSpacing, kChanged);
  EXPECT_TRUE(grown.removed.empty());
  EXPECT_GT(grown.added.size(), static_cast<std::size_t>(count(12)));
  const ChangeTruth shrunk = change_truth(now, before, kSpacing, kChanged);
  EXPECT_GT(shrunk.removed.size(), static_cast<std::size_t>(count(12)));
  EXPECT_GT(shrunk.added.size(), static_cast<std::size_t>(count(12)));
}

TEST(ChangeTruth, BetweenUnchangedAndChangedIsNeither) {
  const ChangeTruth truth = change_truth(with_box(0), with_box(0.05), kSpacing, kChanged);
  EXPECT_TRUE(truth.removed.empty());
  EXPECT_TRUE(truth.added.empty());
  for (const auto& p : truth.unchanged)
    EXPECT_FALSE(p.x() < -0.999 && in_footprint(1.001 * p) && p.z() > 0.1);
}

}  // namespace
}  // namespace evermap
