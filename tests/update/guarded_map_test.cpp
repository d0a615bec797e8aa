// SPDX-FileCopyrightText: 2026 the evermap authors
// SPDX-License-Identifier: BSD-3-Clause
#include <cstring>
#include <support/toy_scene.hpp>
#include <utility>
#include <vector>

#include <gtest/gtest.h>

#include <evermap/update/guarded_map.hpp>

namespace evermap {
namespace {

using Eigen::Vector3d;

/// Keys and raw bytes: nothing less is "bit for bit".
std::vector<std::pair<VoxelKey, std::vector<char>>> image_of(const Octree& octree) {
  std::vector<std::pair<VoxelKey, std::vector<char>>> image;
  octree.for_each_leaf([&](VoxelKey key, const Leaf& leaf) {
    std::vector<char> bytes(sizeof(Leaf));
    std::memcpy(bytes.data(), &leaf, sizeof(Leaf));
    image.emplace_back(key, std::move(bytes));
  });
  return image;
}

Pose at(double x) {
  Pose T_map_sensor;
  T_map_sensor.translation = Vector3d(x, 0, 1.5);
  return T_map_sensor;
}

/// A wall in front of a sensor, and a map that knows it.
class GuardedMapTest : public ::testing::Test {
 protected:
  GuardedMapTest() {
    for (int i = 0; i < 8; ++i) add_scan(octree_, look(with_wall_, at(0.05 * i)), at(0.05 * i), parameters_);
  }

  Scan look(const test::ToyScene& scene, const Pose& T_map_sensor) {
    return scene.scan(T_map_sensor, 4000, 0.01, random_);
  }
  /// The wall is gone, what stood behind it shows, and the pose is wrong by 0.3 m.
  void update_wrongly(int scans, GuardedMap& map) {
    for (int i = 0; i < scans; ++i) {
      ASSERT_TRUE(map.update(look(without_wall_, at(0.1 * i)), at(0.1 * i + 0.3)));
    }
  }
  GuardedMap guarded(std::size_t probation) const {
    return {octree_, parameters_, {.max_contradicting = 1, .at_first = 1, .probation = probation}};
  }

  test::Random random_{3};
  test::ToyScene with_wall_{0, {{Vector3d(6, -4, 0), Vector3d(6.5, 4, 3)}}};
  test::ToyScene without_wall_{0, {{Vector3d(9, -6, 0), Vector3d(9.5, 6, 4)}}};
  UpdateParameters parameters_;
  Octree octree_{VoxelGrid{0.2}};
};

TEST_F(GuardedMapTest, TakesBackEveryBit) {
  for (const bool trims : {false, true}) {
    parameters_.difference = trims ? Difference::kSoft : Difference::kNone;
    GuardedMap map = guarded(10);
    update_wrongly(6, map);
    ASSERT_NE(image_of(map.octree()), image_of(octree_));
    EXPECT_EQ(map.take_back(), 6U);
    EXPECT_EQ(image_of(map.octree()), image_of(octree_));
    EXPECT_EQ(map.octree().leaf_count(), octree_.leaf_count());
    EXPECT_EQ(map.take_back(), 0U);
  }
}

TEST_F(GuardedMapTest, WhatHasAgedOutIsFinal) {
  GuardedMap map = guarded(2);
  update_wrongly(3, map);
  const auto after_three = image_of(map.octree());
  update_wrongly(2, map);
  ASSERT_NE(image_of(map.octree()), after_three);
  EXPECT_EQ(map.take_back(), 2U);
  EXPECT_EQ(image_of(map.octree()), after_three);
}

TEST_F(GuardedMapTest, OfNoScansTakesNothingBack) {
  GuardedMap map = guarded(0);
  update_wrongly(2, map);
  const auto after = image_of(map.octree());
  EXPECT_EQ(map.take_back(), 0U);
  EXPECT_EQ(image_of(map.octree()), after);
}

TEST_F(GuardedMapTest, RefusesAScanThatContradictsTooMuch) {
  GuardedMap map(octree_, parameters_, {.max_contradicting = 0.15, .probation = 5});
  // The wall that every ray to the front meets is said to be gone.
  EXPECT_FALSE(map.update(look(without_wall_, at(0)), at(0)));
  EXPECT_EQ(image_of(map.octree()), image_of(octree_));
  EXPECT_EQ(map.take_back(), 0U);
  EXPECT_TRUE(map.update(look(with_wall_, at(0)), at(0)));
  EXPECT_EQ(map.take_back(), 1U);
}

TEST_F(GuardedMapTest, UpdatesLikeUpdateItself) {
  GuardedMap map = guarded(3);
  Viewpoint viewpoint(parameters_.standstill);
  for (int i = 0; i < 6; ++i) {
    const Scan scan = look(without_wall_, at(0.04 * i));
    map.update(scan, at(0.04 * i));
    update(octree_, scan, at(0.04 * i), parameters_, viewpoint.novelty(at(0.04 * i)));
  }
  EXPECT_EQ(image_of(map.octree()), image_of(octree_));
}

}  // namespace
}  // namespace evermap
