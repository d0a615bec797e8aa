// SPDX-FileCopyrightText: 2026 the evermap authors
// SPDX-License-Identifier: BSD-3-Clause
#include <cmath>
#include <cstring>
#include <random>
#include <thread>

#include <gtest/gtest.h>

#include <evermap/simulation/simulator.hpp>

namespace evermap {
namespace {

/// A room seen from inside: every beam hits a wall.
Scene room(const Eigen::Vector3d& center = Eigen::Vector3d::Zero()) {
  Scene scene;
  Pose T_map_box;
  T_map_box.translation = center;
  add_box(scene, 5, T_map_box, {20, 12, 6});
  return scene;
}

/// Distance from inside an axis-parallel box to its wall.
double to_wall(const Eigen::Vector3d& p, const Eigen::Vector3d& d, const Eigen::Vector3d& half) {
  double range = std::numeric_limits<double>::infinity();
  for (int axis = 0; axis < 3; ++axis) {
    if (d[axis] != 0) range = std::min(range, (std::copysign(half[axis], d[axis]) - p[axis]) / d[axis]);
  }
  return range;
}

Pose tilted(const Eigen::Vector3d& translation) {
  return {Eigen::AngleAxisd(0.8, Eigen::Vector3d(0.3, -0.2, 1).normalized()).toRotationMatrix(), translation};
}

bool same_bytes(const Scan& a, const Scan& b) {
  return a.p_sensor.size() == b.p_sensor.size() &&
         std::memcmp(a.p_sensor.data(), b.p_sensor.data(), a.p_sensor.size() * sizeof(a.p_sensor[0])) == 0;
}

TEST(Simulator, RangeToABoxIsExact) {
  const Simulator simulator(room());
  std::mt19937 generator(1);
  std::uniform_real_distribution<double> unit(-1, 1);
  for (int i = 0; i < 2000; ++i) {
    const Eigen::Vector3d p(9 * unit(generator), 5 * unit(generator), 2 * unit(generator));
    const Eigen::Vector3d d(unit(generator), unit(generator), unit(generator));
    const auto range = simulator.range(p, d);
    ASSERT_TRUE(range);
    ASSERT_NEAR(*range, to_wall(p, d.normalized(), {10, 6, 3}), 1e-9);
  }
}

TEST(Simulator, IsAsExactFarFromTheOrigin) {
  const Eigen::Vector3d far(691000, 5335000, 520);
  const Simulator simulator(room(far));
  const Eigen::Vector3d p(1, 2, 0.5);
  const Eigen::Vector3d d = Eigen::Vector3d(3, 1, 0.2).normalized();
  EXPECT_NEAR(simulator.range(far + p, d).value(), to_wall(p, d, {10, 6, 3}), 1e-8);
}

TEST(Simulator, SeesTheNearestOfTwoThingsAndNothingBeside) {
  Scene scene;
  for (const double x : {5.0, 9.0}) {
    Pose T_map_box;
    T_map_box.translation.x() = x;
    add_box(scene, static_cast<int>(x), T_map_box, {1, 1, 1});
  }
  const Simulator simulator(scene);
  EXPECT_NEAR(simulator.range({0, 0.1, 0}, {1, 0, 0}).value(), 4.5, 1e-12);
  EXPECT_NEAR(simulator.range({7, 0.1, 0}, {2, 0, 0}).value(), 1.5, 1e-12);
  EXPECT_FALSE(simulator.range({0, 0, 0}, {-1, 0, 0}));
  EXPECT_FALSE(simulator.range({0, 2, 0}, {1, 0, 0}));
}

TEST(Simulator, AnEmptySceneReturnsNothing) {
  const Simulator simulator{Scene{}};
  EXPECT_FALSE(simulator.range({0, 0, 0}, {1, 0, 0}));
  EXPECT_TRUE(simulator.scan({}, {}, 1).p_sensor.empty());
}

TEST(Simulator, HitsAreTrueAndInTheOrderOfTheScan) {
  const Simulator simulator(room());
  const Pose T_map_sensor = tilted({1, -2, 0.5});
  LidarModel lidar;
  lidar.range_sigma = 0;
  const auto hits = simulator.hits(T_map_sensor, lidar);
  const Scan scan = simulator.scan(T_map_sensor, lidar, 1);
  ASSERT_EQ(hits.size(), static_cast<std::size_t>(lidar.beams()));
  ASSERT_EQ(scan.p_sensor.size(), hits.size());
  for (std::size_t i = 0; i < hits.size(); ++i) {
    const Eigen::Vector3d direction = T_map_sensor.rotation * lidar.direction(hits[i].beam);
    ASSERT_NEAR(hits[i].range, to_wall(T_map_sensor.translation, direction, {10, 6, 3}), 1e-9);
    ASSERT_LT((T_map_sensor * scan.p_sensor[i] - hits[i].p_map).norm(), 1e-9);
    ASSERT_EQ(hits[i].object, 5);
  }
}

TEST(Simulator, ReturnsOnlyWhatIsInRange) {
  const Simulator simulator(room());
  LidarModel lidar;
  lidar.min_range = 7;
  lidar.max_range = 9;
  const auto hits = simulator.hits(tilted({0, 0, 0}), lidar);
  EXPECT_GT(hits.size(), 1000u);
  EXPECT_LT(hits.size(), static_cast<std::size_t>(lidar.beams()));
  for (const auto& hit : hits) {
    EXPECT_GE(hit.range, 7);
    EXPECT_LE(hit.range, 9);
  }
}

TEST(Simulator, NoiseIsNormalAlongTheBeam) {
  const Simulator simulator(room());
  const LidarModel lidar;
  const auto hits = simulator.hits({}, lidar);
  const Scan scan = simulator.scan({}, lidar, 42);
  double sum = 0;
  double sum_squares = 0;
  double neighbours = 0;
  double previous = 0;
  int beyond_two_sigma = 0;
  for (std::size_t i = 0; i < hits.size(); ++i) {
    const Eigen::Vector3d direction = lidar.direction(hits[i].beam);
    const double error = scan.p_sensor[i].dot(direction) - hits[i].range;
    ASSERT_LT(scan.p_sensor[i].cross(direction).norm(), 1e-9);
    sum += error;
    sum_squares += error * error;
    neighbours += error * previous;
    previous = error;
    beyond_two_sigma += std::abs(error) > 2 * lidar.range_sigma ? 1 : 0;
  }
  const auto n = static_cast<double>(hits.size());
  // The bounds are five standard errors of each figure.
  EXPECT_NEAR(sum / n, 0, 5 * 0.02 / std::sqrt(n));
  EXPECT_NEAR(std::sqrt(sum_squares / n), 0.02, 5 * 0.02 / std::sqrt(2 * n));
  EXPECT_NEAR(beyond_two_sigma / n, 0.0455, 5 * std::sqrt(0.0455 / n));
  EXPECT_NEAR(neighbours / n / (0.02 * 0.02), 0, 5 / std::sqrt(n));
}

TEST(Simulator, ASeedGivesTheSameBytesAndAnotherSeedOthers) {
  const Simulator simulator(room());
  const Simulator another(room());
  const Pose T_map_sensor = tilted({1, 1, 0});
  const Scan scan = simulator.scan(T_map_sensor, {}, 7);
  EXPECT_TRUE(same_bytes(scan, simulator.scan(T_map_sensor, {}, 7)));
  EXPECT_TRUE(same_bytes(scan, another.scan(T_map_sensor, {}, 7)));
  EXPECT_FALSE(same_bytes(scan, simulator.scan(T_map_sensor, {}, 8)));
}

TEST(Simulator, ThreadsDoNotDisturbEachOther) {
  const Simulator simulator(room());
  const Pose T_map_sensor = tilted({1, 1, 0});
  const Scan expected = simulator.scan(T_map_sensor, {}, 7);
  std::vector<Scan> scans(4);
  std::vector<std::thread> threads;
  for (Scan& scan : scans) threads.emplace_back([&] { scan = simulator.scan(T_map_sensor, {}, 7); });
  for (std::thread& thread : threads) thread.join();
  for (const Scan& scan : scans) EXPECT_TRUE(same_bytes(scan, expected));
}

// The generator is part of the contract: a recorded seed must give the same noise in later versions.
TEST(Simulator, NoiseOfASeedIsFixedForEver) {
  const Simulator simulator(room());
  LidarModel lidar;
  lidar.channels = 1;
  lidar.columns = 3;
  lidar.elevation_max = 0;
  lidar.range_sigma = 1;
  const auto hits = simulator.hits({}, lidar);
  const Scan scan = simulator.scan({}, lidar, 1);
  ASSERT_EQ(scan.p_sensor.size(), 3u);
  const auto noise = [&](std::size_t i) {
    return scan.p_sensor[i].dot(lidar.direction(hits[i].beam)) - hits[i].range;
  };
  EXPECT_NEAR(noise(0), -0.3672854034217991, 1e-12);
  EXPECT_NEAR(noise(1), 0.3271662835920535, 1e-12);
  EXPECT_NEAR(noise(2), 0.1368354432695994, 1e-12);
}

}  // namespace
}  // namespace evermap
