// SPDX-FileCopyrightText: 2026 the evermap authors
// SPDX-License-Identifier: BSD-3-Clause
#include <atomic>
#include <cstring>
#include <support/toy_scene.hpp>
#include <thread>
#include <utility>
#include <vector>

#include <Eigen/Geometry>
#include <gtest/gtest.h>

#include "localization/worlds.hpp"
#include <evermap/maintenance/map_maintainer.hpp>
#include <evermap/map/map_difference.hpp>
#include <evermap/update/detail/map_updater.hpp>
#include <evermap/update/detail/viewpoint.hpp>

namespace evermap {
namespace {

using Eigen::Vector3d;
using Image = std::vector<std::pair<VoxelKey, std::vector<char>>>;

/// Keys and raw bytes: nothing less is "bit for bit".
Image image_of(const Octree& octree) {
  Image image;
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

/// A wall in front of a sensor, a map that knows it, and a world in which the wall is gone.
class MapMaintainerTest : public ::testing::Test {
 protected:
  MapMaintainerTest() {
    MapMaintainer mapper(Octree(VoxelGrid{0.2}), {}, MapMode::kMapping);
    for (int i = 0; i < 8; ++i) mapper.process(look(with_wall_, at(0.05 * i)), at(0.05 * i));
    map_ = mapper.map();
  }

  Scan look(const test::ToyScene& scene, const Pose& T_map_sensor) {
    return scene.scan(T_map_sensor, 4000, 0.01, random_);
  }

  test::Random random_{3};
  test::ToyScene with_wall_{0, {{Vector3d(6, -4, 0), Vector3d(6.5, 4, 3)}}};
  test::ToyScene without_wall_{0, {{Vector3d(9, -6, 0), Vector3d(9.5, 6, 4)}}};
  Octree map_{VoxelGrid{0.2}};
};

TEST_F(MapMaintainerTest, WithGivenPosesDoesWhatUpdateDoes) {
  const Parameters parameters;
  MapMaintainer maintainer(map_, parameters);
  Octree twin = map_;
  Viewpoint viewpoint(parameters.update.standstill);
  for (int i = 0; i < 6; ++i) {
    const Scan scan = look(without_wall_, at(0.04 * i));
    const ScanResult result = maintainer.process(scan, at(0.04 * i));
    EXPECT_TRUE(result.is_written);
    update(twin, condense(scan, at(0.04 * i), twin.grid(), parameters.lidar), parameters.update,
           viewpoint.view_weight(at(0.04 * i)));
  }
  EXPECT_TRUE(image_of(maintainer.map()) == image_of(twin));
  EXPECT_FALSE(image_of(twin) == image_of(map_));
}

std::size_t occupied_leaves(const Octree& octree) {
  std::size_t count = 0;
  octree.for_each_leaf([&](VoxelKey, const Leaf& leaf) { count += leaf.occupied() ? 1U : 0U; });
  return count;
}

TEST_F(MapMaintainerTest, UndoesTheMotionBetweenGivenPoses) {
  const Pose T_map_begin = at(0.3);
  Pose T_map_end = at(1.1);  // 8 m/s, and turning
  T_map_end.rotation = Eigen::AngleAxisd(0.1, Vector3d::UnitZ()).toRotationMatrix();
  const Scan still = look(with_wall_, T_map_end);
  const Twist motion = log(T_map_begin.inverse() * T_map_end);
  Scan raw;
  for (std::size_t i = 0; i < still.p_sensor.size(); ++i) {
    const double fraction = static_cast<double>(i + 1) / static_cast<double>(still.p_sensor.size());
    raw.p_sensor.push_back(exp((1 - fraction) * motion) * still.p_sensor[i]);
    raw.time_offset.push_back(static_cast<float>(0.1 * fraction));
  }
  const auto leaves_of = [&](const Scan& scan, const std::optional<Pose>& T_map_sensor_begin) {
    MapMaintainer mapper(Octree(VoxelGrid{0.2}), {}, MapMode::kMapping);
    mapper.process(scan, T_map_end, T_map_sensor_begin);
    return mapper.map();
  };
  const Octree expected = leaves_of(still, std::nullopt);
  const MapDifference mended = compare(expected, leaves_of(raw, T_map_begin));
  const MapDifference distorted = compare(expected, leaves_of(raw, std::nullopt));
  const auto wrong = [](const MapDifference& d) { return d.added.size() + d.removed.size(); };
  EXPECT_LT(wrong(mended), expected.leaf_count() / 100);
  EXPECT_GT(wrong(distorted), expected.leaf_count() / 4);
}

TEST_F(MapMaintainerTest, TellsWhatChanged) {
  MapMaintainer maintainer(map_);
  std::size_t before = occupied_leaves(map_);
  std::size_t became_occupied = 0;
  std::size_t erased = 0;
  for (int i = 0; i < 10; ++i) {
    const ScanResult result = maintainer.process(look(without_wall_, at(0.2 * i)), at(0.2 * i));
    const std::size_t after = occupied_leaves(maintainer.map());
    EXPECT_EQ(before + result.leaves_occupied - result.leaves_erased, after);
    before = after;
    became_occupied += result.leaves_occupied;
    erased += result.leaves_erased;
  }
  EXPECT_GT(became_occupied, 20U);
  EXPECT_GT(erased, 20U);
}

TEST_F(MapMaintainerTest, AScanWithoutUsablePointsCostsNothingButItself) {
  MapMaintainer maintainer(map_);
  Scan near;
  near.p_sensor = {{0.1, 0, 0}, {0, 0.2, 0}};
  for (const Scan& scan : {Scan{}, near}) {
    const ScanResult result = maintainer.process(scan, at(0));
    EXPECT_EQ(result.reject_reason, RejectReason::kNoUsablePoint);
    EXPECT_FALSE(result.is_written);
    EXPECT_EQ(result.points.total, scan.p_sensor.size());
    EXPECT_EQ(result.points.near, scan.p_sensor.size());
  }
  EXPECT_TRUE(image_of(maintainer.map()) == image_of(map_));
  EXPECT_TRUE(maintainer.process(look(with_wall_, at(0)), at(0)).is_written);
}

TEST_F(MapMaintainerTest, AccountsForEveryPoint) {
  Scan scan;
  scan.p_sensor = {{0.1, 0, 0}, {300, 0, 0}, {0, 400, 0}, {3, 0, 0}, {3.01, 0, 0}, {5, 5, 0}, {0, 0, 190}};
  scan.dropped_not_finite = 2;
  scan.dropped_at_origin = 3;
  Pose high;
  high.translation.z() = 0.2 * VoxelKey::kMaxZ - 150;
  for (const MapMode mode : {MapMode::kMapping, MapMode::kMaintenance}) {
    MapMaintainer maintainer(Octree(VoxelGrid{0.2}), {}, mode);
    const ScanResult::PointCounts points = maintainer.process(scan, high).points;
    EXPECT_EQ(points.total, 12U);
    EXPECT_EQ(points.used, 3U);
    EXPECT_EQ(points.not_finite, 2U);
    EXPECT_EQ(points.at_origin, 3U);
    EXPECT_EQ(points.near, 1U);
    EXPECT_EQ(points.far, 2U);
    EXPECT_EQ(points.out_of_grid, 1U);
    EXPECT_EQ(maintainer.map().leaf_count(), 2U);
  }
}

/// A drive through the yard, and the map of its survey.
class ClosedLoopTest : public ::testing::Test {
 protected:
  static Pose truth(std::size_t i) { return test::yard().T_map_sensor(i); }
  static Scan look(std::size_t i) { return look(test::yard().scene(0), i); }
  static Scan look(const Scene& scene, std::size_t i) {
    return Simulator(scene).scan(truth(i), test::small_lidar(), i);
  }
  static double time(std::size_t i) { return 0.1 * static_cast<double>(i); }

  const Octree map_ = test::survey_map(test::yard().survey_scene(), 0.4);
};

TEST_F(ClosedLoopTest, FollowsTheSensorAndWritesWhatItBelieves) {
  MapMaintainer maintainer(map_, {}, MapMode::kMaintenance, truth(0));
  int written = 0;
  for (std::size_t i = 0; i < 10; ++i) {
    const ScanResult result = maintainer.process(look(i), time(i), truth(i));
    EXPECT_LT((result.T_map_sensor.translation - truth(i).translation).norm(), 0.02) << i;
    EXPECT_EQ(result.is_written, result.is_believed()) << i;
    written += result.is_written ? 1 : 0;
  }
  EXPECT_EQ(written, 9);  // all but the first, when the motion was not known yet
  EXPECT_FALSE(image_of(maintainer.map()) == image_of(map_));
}

/// Not before the motion is known; then its first scans are located again, deskewed, and written.
TEST_F(ClosedLoopTest, BelievesTheScansOfAStartOnceTheMotionIsKnown) {
  for (const bool has_odometry : {false, true}) {
    const std::size_t starting = has_odometry ? 1 : 2;
    MapMaintainer maintainer(map_, {}, MapMode::kMaintenance, truth(0));
    std::vector<ScanResult> run;
    for (std::size_t i = 0; i < 5; ++i) {
      const ScanResult result =
          maintainer.process(look(i), time(i), has_odometry ? std::optional(truth(i)) : std::nullopt);
      EXPECT_EQ(result.is_believed(), i >= starting) << i;
      EXPECT_EQ(result.confirmed.size(), i == starting ? starting : 0) << i;
      append(run, result);
    }
    ASSERT_EQ(run.size(), 5U);
    for (std::size_t i = 0; i < run.size(); ++i) {
      EXPECT_EQ(run[i].time, time(i));
      EXPECT_TRUE(run[i].is_believed()) << i;
      EXPECT_TRUE(run[i].is_written) << i;
      EXPECT_TRUE(run[i].confirmed.empty()) << i;
      EXPECT_LT((run[i].T_map_sensor.translation - truth(i).translation).norm(), 0.02) << i;
    }
  }
}

TEST_F(ClosedLoopTest, DoesNotBelieveAStartThatNothingConfirms) {
  MapMaintainer maintainer(map_, {}, MapMode::kMaintenance, truth(0));
  std::vector<ScanResult> run;
  append(run, maintainer.process(look(0), time(0)));
  for (std::size_t i = 1; i < 8; ++i) append(run, maintainer.process(Scan{}, time(i)));
  EXPECT_EQ(maintainer.state(), TrackingState::kLost);
  for (const ScanResult& scan : run) EXPECT_FALSE(scan.is_believed() || scan.is_written);
  EXPECT_TRUE(image_of(maintainer.map()) == image_of(map_));
}

TEST_F(ClosedLoopTest, LocalizationAloneChangesNothing) {
  MapMaintainer maintainer(map_, {}, MapMode::kLocalization, truth(0));
  for (std::size_t i = 0; i < 5; ++i) {
    EXPECT_FALSE(maintainer.process(look(i), time(i), truth(i)).is_written);
  }
  EXPECT_EQ(maintainer.state(), TrackingState::kTracking);
  EXPECT_TRUE(image_of(maintainer.map()) == image_of(map_));
}

TEST_F(ClosedLoopTest, WithoutAMapTheFirstScanMakesIt) {
  for (const MapMode mode : {MapMode::kMapping, MapMode::kMaintenance}) {
    MapMaintainer maintainer(Octree(VoxelGrid{0.4}), {}, mode, truth(0));
    const ScanResult first = maintainer.process(look(0), 0);
    EXPECT_TRUE(first.is_written);
    EXPECT_EQ(first.T_map_sensor.translation, truth(0).translation);
    EXPECT_EQ(first.state, TrackingState::kStarting);
    EXPECT_GT(occupied_leaves(maintainer.map()), 100U);
    EXPECT_FALSE(first.is_believed());
    const ScanResult second = maintainer.process(look(1), time(1));
    ASSERT_EQ(second.confirmed.size(), 1U);
    EXPECT_TRUE(second.confirmed[0].is_believed());
    EXPECT_EQ(second.confirmed[0].T_map_sensor.translation, truth(0).translation);
  }
}

/// What was written while the robot was going astray is undone, bit for bit, when it is lost.
TEST_F(ClosedLoopTest, RollsBackWhenTheRobotIsLost) {
  for (const int held : {20, 0}) {
    Parameters parameters;
    parameters.rollback.scans = held;
    MapMaintainer maintainer(map_, parameters, MapMode::kMaintenance, truth(0));
    for (std::size_t i = 0; i < 6; ++i) maintainer.process(look(i), time(i), truth(i));
    ASSERT_FALSE(image_of(maintainer.map()) == image_of(map_));
    std::size_t rolled_back = 0;
    for (std::size_t i = 6; i < 14; ++i) {
      rolled_back += maintainer.process(Scan{}, time(i), truth(i)).rolled_back;
    }
    EXPECT_EQ(maintainer.state(), TrackingState::kLost);
    EXPECT_EQ(rolled_back, held == 0 ? 0U : 6U);
    EXPECT_EQ(image_of(maintainer.map()) == image_of(map_), held > 0);
  }
}

/// An outdated map is what we are for: where no other place explains a scan, its contradictions are true.
TEST_F(ClosedLoopTest, BelievesContradictionsThatNoOtherPlaceExplains) {
  Parameters parameters;
  parameters.localization.gate.max_contradicting = 0;
  MapMaintainer maintainer(map_, parameters, MapMode::kMaintenance, truth(0));
  maintainer.process(look(0), 0, truth(0));
  const ScanResult result = maintainer.process(look(1), time(1), truth(1));
  EXPECT_GT(result.contradicting_fraction, 0);
  EXPECT_TRUE(result.is_written) << to_string(result.reject_reason);
}

/// Whoever looks at the map while scans come in sees it as it was after one of them, and it stays so.
TEST_F(MapMaintainerTest, ThreadsThatReadSeeWholeScans) {
  std::vector<Scan> scans;
  for (int i = 0; i < 20; ++i) scans.push_back(look(without_wall_, at(0.1 * i)));
  std::vector<Image> after;  // each scan, and before the first
  {
    MapMaintainer alone(map_);
    after.push_back(image_of(alone.map()));
    for (int i = 0; i < 20; ++i) {
      alone.process(scans[static_cast<std::size_t>(i)], at(0.1 * i));
      after.push_back(image_of(alone.map()));
    }
  }
  MapMaintainer maintainer(map_);
  std::atomic<bool> done = false;
  std::vector<Octree> seen;
  std::thread reader([&] {
    while (!done) seen.push_back(maintainer.map());
  });
  for (int i = 0; i < 20; ++i) maintainer.process(scans[static_cast<std::size_t>(i)], at(0.1 * i));
  done = true;
  reader.join();
  ASSERT_FALSE(seen.empty());
  EXPECT_TRUE(image_of(maintainer.map()) == after.back());
  std::size_t at_least = 0;
  const std::size_t step = 1 + seen.size() / 100;
  for (std::size_t i = 0; i < seen.size(); i += step) {
    const Image image = image_of(seen[i]);
    while (at_least < after.size() && image != after[at_least]) ++at_least;
    ASSERT_LT(at_least, after.size()) << "a view that no scan left, or that went back in time";
  }
}

}  // namespace
}  // namespace evermap
