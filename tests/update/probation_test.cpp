// SPDX-FileCopyrightText: 2026 the evermap authors
// SPDX-License-Identifier: BSD-3-Clause
#include <cstring>
#include <support/toy_scene.hpp>
#include <utility>
#include <vector>

#include <gtest/gtest.h>

#include <evermap/update/map_updater.hpp>
#include <evermap/update/probation.hpp>

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
class ProbationTest : public ::testing::Test {
 protected:
  ProbationTest() {
    for (int i = 0; i < 8; ++i) add_scan(octree_, look(with_wall_, at(0.05 * i)), at(0.05 * i), parameters_);
  }

  Scan look(const test::ToyScene& scene, const Pose& T_map_sensor) {
    return scene.scan(T_map_sensor, 4000, 0.01, random_);
  }
  /// The wall is gone, what stood behind it shows, and the pose is wrong by 0.3 m.
  void update_wrongly(int scans, Probation& probation) {
    for (int i = 0; i < scans; ++i) {
      update(octree_, look(without_wall_, at(0.1 * i)), at(0.1 * i + 0.3), parameters_, 1, &probation);
    }
  }

  test::Random random_{3};
  test::ToyScene with_wall_{0, {{Vector3d(6, -4, 0), Vector3d(6.5, 4, 3)}}};
  test::ToyScene without_wall_{0, {{Vector3d(9, -6, 0), Vector3d(9.5, 6, 4)}}};
  UpdateParameters parameters_;
  Octree octree_{VoxelGrid{0.2}};
};

TEST_F(ProbationTest, TakesBackEveryBit) {
  for (const bool trims : {false, true}) {
    parameters_.difference = trims ? Difference::kSoft : Difference::kNone;
    const auto before = image_of(octree_);
    const std::size_t leaves = octree_.leaf_count();
    Probation probation(10);
    update_wrongly(6, probation);
    EXPECT_EQ(probation.scans(), 6U);
    ASSERT_NE(image_of(octree_), before);
    probation.take_back(octree_);
    EXPECT_EQ(image_of(octree_), before);
    EXPECT_EQ(octree_.leaf_count(), leaves);
    EXPECT_EQ(probation.scans(), 0U);
  }
}

TEST_F(ProbationTest, WhatHasAgedOutIsFinal) {
  Probation probation(2);
  update_wrongly(3, probation);
  EXPECT_EQ(probation.scans(), 2U);
  const auto after_three = image_of(octree_);
  update_wrongly(2, probation);
  ASSERT_NE(image_of(octree_), after_three);
  probation.take_back(octree_);
  EXPECT_EQ(image_of(octree_), after_three);
}

TEST_F(ProbationTest, OfNoScansTakesNothingBack) {
  Probation probation(0);
  update_wrongly(2, probation);
  const auto after = image_of(octree_);
  probation.take_back(octree_);
  EXPECT_EQ(image_of(octree_), after);
}

}  // namespace
}  // namespace evermap
