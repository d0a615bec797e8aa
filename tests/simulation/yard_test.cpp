// SPDX-FileCopyrightText: 2026 the evermap authors
// SPDX-License-Identifier: BSD-3-Clause
#include <algorithm>
#include <cmath>
#include <map>
#include <set>

#include <gtest/gtest.h>

#include <evermap/simulation/change_truth.hpp>
#include <evermap/simulation/simulator.hpp>
#include <evermap/simulation/surface_index.hpp>
#include <evermap/simulation/yard.hpp>

namespace evermap {
namespace {

std::vector<Eigen::Vector3d> corners_of(const Scene& scene, int object) {
  std::vector<Eigen::Vector3d> corners;
  for (std::size_t i = 0; i < scene.triangles.size(); ++i) {
    if (scene.object[i] != object) continue;
    for (const auto index : scene.triangles[i]) corners.push_back(scene.vertices[index]);
  }
  return corners;
}

std::set<int> objects_of(const Scene& scene) { return {scene.object.begin(), scene.object.end()}; }

Eigen::AlignedBox3d bounds_of(const Scene& scene, int object) {
  Eigen::AlignedBox3d bounds;
  for (const auto& corner : corners_of(scene, object)) bounds.extend(corner);
  return bounds;
}

class YardTest : public testing::Test {
 protected:
  const Yard yard = make_yard();
};

TEST_F(YardTest, IsSixtyMetresWideOnGroundThatSlopesGently) {
  const Eigen::AlignedBox3d ground = bounds_of(yard.now, 0);
  EXPECT_TRUE(ground.sizes().head<2>().isApprox(Eigen::Vector2d(60, 60)));
  double steepest = 0;
  for (std::size_t i = 0; i < yard.now.triangles.size(); ++i) {
    if (yard.now.object[i] != 0) continue;
    const Eigen::Vector3d n = yard.now.triangle(i).scaled_normal();
    steepest = std::max(steepest, n.head<2>().norm() / n.z());
  }
  EXPECT_GT(steepest, 0.03);
  EXPECT_LT(steepest, 0.08);
}

TEST_F(YardTest, DiffersInFourThings) {
  std::set<int> before = objects_of(yard.before);
  std::set<int> now = objects_of(yard.now);
  EXPECT_EQ(before.erase(Yard::kVanished), 1u);
  EXPECT_EQ(now.erase(Yard::kAppeared), 1u);
  EXPECT_EQ(before, now);
  EXPECT_FALSE(before.contains(Yard::kAppeared));
  for (const int object : before) {
    const bool same = corners_of(yard.before, object) == corners_of(yard.now, object);
    EXPECT_EQ(same, object != Yard::kMoved && object != Yard::kHeap) << object;
  }
}

TEST_F(YardTest, OneBoxMovedByAQuarterMetreAsAWhole) {
  const auto before = corners_of(yard.before, Yard::kMoved);
  const auto now = corners_of(yard.now, Yard::kMoved);
  ASSERT_EQ(before.size(), now.size());
  for (std::size_t i = 0; i < before.size(); ++i) {
    EXPECT_NEAR((now[i] - before[i]).norm(), 0.25, 1e-9);
    EXPECT_NEAR(now[i].z(), before[i].z(), 1e-9);
  }
}

TEST_F(YardTest, TheHeapGrew) {
  const Eigen::Vector3d before = bounds_of(yard.before, Yard::kHeap).sizes();
  const Eigen::Vector3d now = bounds_of(yard.now, Yard::kHeap).sizes();
  EXPECT_NEAR(before.x(), 6, 1e-9);
  EXPECT_NEAR(now.x(), 7.6, 1e-9);
  EXPECT_NEAR(now.z() - before.z(), 0.6, 0.1);
}

// A bottom that hangs in the air would be surface that no builder meant.
TEST_F(YardTest, EveryBoxStandsInTheGround) {
  for (const Scene* scene : {&yard.before, &yard.now}) {
    const SurfaceIndex index(*scene);
    for (const int object : objects_of(*scene)) {
      if (object == 0 || object == Yard::kHeap) continue;
      const auto corners = corners_of(*scene, object);
      const auto below = std::count_if(corners.begin(), corners.end(),
                                       [&](const auto& corner) { return index.buried(corner, object); });
      // Of the 36 corners of a box's 12 triangles 18 are at the bottom; walls meet in each other.
      EXPECT_GE(below, 18) << object;
    }
  }
}

TEST_F(YardTest, IsDrivenThroughAtTwoToFiveMetresPerSecondLookingAhead) {
  const auto& poses = yard.T_map_sensor;
  ASSERT_EQ(poses.size(), 60u);
  const Simulator simulator(yard.now);
  for (std::size_t i = 0; i < poses.size(); ++i) {
    EXPECT_TRUE(is_rotation(poses[i].rotation, 1e-9));
    EXPECT_NEAR(simulator.range(poses[i].translation, -Eigen::Vector3d::UnitZ()).value(), 1.7, 0.01);
    if (i == 0) continue;
    const Eigen::Vector3d step = poses[i].translation - poses[i - 1].translation;
    EXPECT_GT(step.norm() / 0.1, 1.9);
    EXPECT_LT(step.norm() / 0.1, 5.1);
    EXPECT_GT(step.normalized().dot(poses[i].rotation.col(0)), 0.99);
  }
  EXPECT_LT(poses.front().rotation.col(0).dot(poses.back().rotation.col(0)), 0.1) << "no curve";
}

TEST_F(YardTest, TheDriveKeepsClearOfEverything) {
  for (const Scene* scene : {&yard.before, &yard.now}) {
    const SurfaceIndex index(*scene);
    for (const Pose& T_map_sensor : yard.T_map_sensor) {
      EXPECT_FALSE(index.buried(T_map_sensor.translation));
      EXPECT_TRUE(std::isinf(index.distance(T_map_sensor.translation, 1.5)));
    }
  }
}

TEST_F(YardTest, TheDriveSeesEveryChange) {
  const Simulator before(yard.before);
  const Simulator now(yard.now);
  std::map<int, int> hits_before;
  std::map<int, int> hits_now;
  for (std::size_t i = 0; i < yard.T_map_sensor.size(); i += 10) {
    for (const auto& hit : before.hits(yard.T_map_sensor[i], {})) ++hits_before[hit.object];
    for (const auto& hit : now.hits(yard.T_map_sensor[i], {})) ++hits_now[hit.object];
  }
  EXPECT_GT(hits_before[Yard::kVanished], 5000);
  EXPECT_GT(hits_now[Yard::kAppeared], 5000);
  EXPECT_GT(hits_now[Yard::kMoved], 5000);
  EXPECT_GT(hits_now[Yard::kHeap], 2000);
  EXPECT_EQ(hits_now.size(), objects_of(yard.now).size()) << "something is never seen";
}

TEST_F(YardTest, ItsTruthHoldsAllKindsOfPoints) {
  const ChangeTruth truth = change_truth(yard.before, yard.now, 0.1, 0.1);
  EXPECT_GT(truth.now.size(), 350000u);
  EXPECT_GT(truth.unchanged.size(), 345000u);
  EXPECT_GT(truth.removed.size(), 1500u);
  EXPECT_LT(truth.removed.size(), 4000u);
  EXPECT_GT(truth.added.size(), 5000u);
  EXPECT_LT(truth.added.size(), 10000u);
}

}  // namespace
}  // namespace evermap
