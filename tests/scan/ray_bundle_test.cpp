// SPDX-FileCopyrightText: 2026 the evermap authors
// SPDX-License-Identifier: BSD-3-Clause
#include <cmath>
#include <map>
#include <set>
#include <support/random_geometry.hpp>
#include <vector>

#include <Eigen/Eigenvalues>
#include <gtest/gtest.h>

#include <evermap/scan/detail/ray_bundle.hpp>

namespace evermap {
namespace {

using Eigen::Matrix3d;
using Eigen::Vector3d;
using Eigen::Vector3i;
using test::Random;

Pose random_pose(Random& random, const Vector3d& place) {
  return {random.rotation(), place + random.in_cube(10)};
}

/// A few surfaces of points around the sensor, and points that are too near or too far.
Scan random_scan(Random& random, int points) {
  Scan scan;
  for (int surface = 0; surface < 6; ++surface) {
    const Vector3d center = random.log_uniform(2, 30) * random.direction();
    const Matrix3d axes = random.rotation();
    for (int i = 0; i < points / 6; ++i) {
      scan.p_sensor.emplace_back(center + axes * Vector3d(0.3, 0.5, 0.01).cwiseProduct(random.normal3()));
    }
  }
  for (int i = 0; i < 20; ++i) scan.p_sensor.emplace_back(random.log_uniform(0.01, 1) * random.direction());
  for (int i = 0; i < 20; ++i) scan.p_sensor.emplace_back(random.uniform(150, 250) * random.direction());
  return scan;
}

/// Shrunk and floored moments of the points of one voxel, in two passes of long double.
Gaussian expected_bundle(const std::vector<Vector3d>& points, double s0) {
  using Vector = Eigen::Matrix<long double, 3, 1>;
  Vector sum = Vector::Zero();
  for (const Vector3d& p : points) sum += p.cast<long double>();
  const auto n = static_cast<long double>(points.size());
  const Vector mean = sum / n;
  Eigen::Matrix<long double, 3, 3> S = 2 * s0 * s0 * Eigen::Matrix<long double, 3, 3>::Identity();
  for (const Vector3d& p : points)
    S += (p.cast<long double>() - mean) * (p.cast<long double>() - mean).transpose();
  S /= n + 2;
  const Eigen::SelfAdjointEigenSolver<Matrix3d> eigen(S.cast<double>());
  const Matrix3d V = eigen.eigenvectors();
  return {mean.cast<double>(), V * eigen.eigenvalues().cwiseMax(s0 * s0 / 4).asDiagonal() * V.transpose(),
          static_cast<double>(points.size())};
}

void expect_brute_force(const Scan& scan, const Pose& T_map_sensor, const VoxelGrid& grid,
                        const LidarParameters& lidar) {
  std::map<VoxelKey, std::vector<Vector3d>> voxels;
  std::size_t near = 0, far = 0, on_vehicle = 0;
  for (const Vector3d& p : scan.p_sensor) {
    near += p.norm() < lidar.min_range;
    far += p.norm() > lidar.max_range;
    if (p.norm() < lidar.min_range || p.norm() > lidar.max_range) continue;
    const auto& box = lidar.vehicle_box;
    if ((p.array() >= box.min().array()).all() && (p.array() <= box.max().array()).all()) {
      ++on_vehicle;
      continue;
    }
    const Vector3d p_map = T_map_sensor * p;
    voxels[*grid.key(p_map)].push_back(p_map);
  }
  const BundleGrid found = condense(scan, T_map_sensor, grid, lidar);
  EXPECT_EQ(found.dropped_near, near);
  EXPECT_EQ(found.dropped_far, far);
  EXPECT_EQ(found.dropped_on_vehicle, on_vehicle);
  EXPECT_EQ(found.dropped_out_of_grid, 0U);
  EXPECT_EQ(found.origin_map, T_map_sensor.translation);
  ASSERT_EQ(found.bundles().size(), voxels.size());
  const double s0 = std::max(lidar.range_sigma, 0.02 * grid.edge);
  const double rounding = 2e-16 * T_map_sensor.translation.norm() + 1e-14;  // [m] of a coordinate
  auto bundle = found.bundles().begin();
  for (const auto& [key, points] : voxels) {
    ASSERT_EQ(bundle->key, key);  // in ascending order
    const Gaussian expected = expected_bundle(points, s0);
    EXPECT_LE((bundle->points.mean - expected.mean).norm(), 4 * rounding);
    EXPECT_LE((bundle->points.covariance - expected.covariance).norm(),
              1e-12 * expected.covariance.trace() + rounding * 1e-4);
    EXPECT_EQ(bundle++->points.count, expected.count);
  }
}

TEST(Condense, EqualsBruteForceGrouping) {
  Random random(1);
  for (int i = 0; i < 30; ++i) {
    LidarParameters lidar;
    lidar.range_sigma = random.log_uniform(0.001, 0.05);
    if (random.chance(0.5))
      lidar.vehicle_box = {Vector3d(-3, -1, -2), Vector3d(random.uniform(0, 4), 1, 1.5)};
    const VoxelGrid grid{random.uniform(0.05, 1)};
    expect_brute_force(random_scan(random, 3000), random_pose(random, Vector3d::Zero()), grid, lidar);
  }
}

TEST(Condense, StaysExactFarFromTheOrigin) {
  Random random(2);
  for (const Vector3d& place : {Vector3d(1e6, -1e6, 200), Vector3d(5e6, 4e5, 1000)}) {
    for (int i = 0; i < 5; ++i) {
      const VoxelGrid grid = VoxelGrid::around(place, 0.2);
      expect_brute_force(random_scan(random, 3000), random_pose(random, place), grid, {});
    }
  }
}

TEST(Condense, FindsEveryBundleAndNoOther) {
  Random random(3);
  const VoxelGrid grid{0.2};
  const BundleGrid found =
      condense(random_scan(random, 6000), random_pose(random, Vector3d::Zero()), grid, {});
  std::set<VoxelKey> keys;
  for (const RayBundle& bundle : found.bundles()) {
    EXPECT_EQ(found.find(bundle.key), &bundle);
    EXPECT_EQ(*grid.key(bundle.points.mean), bundle.key);
    EXPECT_TRUE(keys.insert(bundle.key).second);
  }
  EXPECT_GT(keys.size(), 500U);
  for (const VoxelKey key : keys) {
    const Vector3i neighbour = key.voxel() + Vector3i(random.integer(-2, 2), random.integer(-2, 2), 1);
    const VoxelKey other = VoxelKey::from_voxel(neighbour);
    EXPECT_EQ(found.find(other) != nullptr, keys.contains(other));
  }
}

TEST(Condense, EmptyScans) {
  EXPECT_EQ(BundleGrid{}.find(VoxelKey(0)), nullptr);
  const BundleGrid found = condense({}, {}, VoxelGrid{0.2}, {});
  EXPECT_TRUE(found.bundles().empty());
  EXPECT_EQ(found.find(VoxelKey(0)), nullptr);
}

TEST(Condense, CountsWhatItDrops) {
  Scan scan;
  scan.p_sensor = {{0.49, 0, 0}, {0, 0.5, 0}, {0, 0, 200}, {0, 0, 200.001}, {0, 300, 0}};
  // 2^19 voxels of 0.2 m above the grid's origin the keys end; the sensor is 150 m below that.
  Pose high;
  high.translation.z() = 0.2 * VoxelKey::kMaxZ - 150;
  const BundleGrid found = condense(scan, high, VoxelGrid{0.2}, {});
  EXPECT_EQ(found.dropped_near, 1U);
  EXPECT_EQ(found.dropped_far, 2U);
  EXPECT_EQ(found.dropped_out_of_grid, 1U);
  ASSERT_EQ(found.bundles().size(), 1U);
  EXPECT_NEAR(found.bundles()[0].points.mean.y(), 0.5, 1e-12);
}

RayBundle only_bundle(const std::vector<Vector3d>& points, double edge, const LidarParameters& lidar) {
  Scan scan;
  scan.p_sensor = points;
  const BundleGrid found = condense(scan, {}, VoxelGrid{edge}, lidar);
  EXPECT_EQ(found.bundles().size(), 1U);
  return found.bundles().at(0);
}

TEST(Condense, OnePointIsAsWideAsTheNoise) {
  const RayBundle bundle = only_bundle({{1.03, 1.05, 1.08}}, 0.2, {});
  EXPECT_LE((bundle.points.mean - Vector3d(1.03, 1.05, 1.08)).norm(), 1e-14);
  // (0 + 2 s0^2) / (1 + 2) with s0 = 2 cm
  EXPECT_LE((bundle.points.covariance - 2.0 / 3 * 0.0004 * Matrix3d::Identity()).norm(), 1e-16);
  EXPECT_EQ(bundle.points.count, 1);
}

TEST(Condense, TwoPointsSpanALine) {
  const RayBundle bundle = only_bundle({{1.02, 1.1, 1.1}, {1.18, 1.1, 1.1}}, 0.2, {});
  const Vector3d expected((2 * 0.08 * 0.08 + 2 * 0.0004) / 4, 0.0002, 0.0002);
  EXPECT_LE((bundle.points.covariance - Matrix3d(expected.asDiagonal())).norm(), 1e-15);
}

TEST(Condense, ExactPlanesKeepAThickness) {
  Random random(4);
  for (const double edge : {0.2, 0.4, 2.0}) {
    for (const double sigma : {0.0, 0.005, 0.02, 0.1}) {
      LidarParameters lidar;
      lidar.range_sigma = sigma;
      std::vector<Vector3d> points;
      for (int i = 0; i < 5000; ++i) {
        points.emplace_back(2 + random.uniform(0.01, 0.99) * edge, 2 + random.uniform(0.01, 0.99) * edge,
                            2.1);
      }
      const Gaussian bundle = only_bundle(points, edge, lidar).points;
      const double s0 = std::max(sigma, 0.02 * edge);
      EXPECT_EQ(least_thickness(lidar.range_sigma, VoxelGrid{edge}), s0);
      // So many points outweigh the prior: the floor (s0 / 2)^2 is what remains.
      EXPECT_NEAR(bundle.covariance(2, 2), s0 * s0 / 4, 1e-12);
      const Eigen::SelfAdjointEigenSolver<Matrix3d> eigen(bundle.covariance);
      EXPECT_GE(eigen.eigenvalues().minCoeff(), s0 * s0 / 4 * (1 - 1e-9));
    }
  }
}

TEST(Condense, CovarianceStaysWithinItsBound) {
  Random random(5);
  const BundleGrid found =
      condense(random_scan(random, 6000), random_pose(random, Vector3d::Zero()), VoxelGrid{0.4}, {});
  for (const RayBundle& bundle : found.bundles()) {
    EXPECT_LE(bundle.points.covariance.trace(), 0.75 * 0.16 + 3 * 0.0004);
  }
}

TEST(Condense, ThinsEvenlyWhatIsMoreThanAskedFor) {
  Random random(6);
  const Scan scan = random_scan(random, 6000);
  const Pose T_map_sensor = random_pose(random, Vector3d::Zero());
  const std::vector<RayBundle> all = condense(scan, T_map_sensor, VoxelGrid{0.4}, {}).bundles();
  ASSERT_GT(all.size(), 200U);
  const std::vector<RayBundle> some = condense(scan, T_map_sensor, VoxelGrid{0.4}, {}, 70).bundles();
  ASSERT_EQ(some.size(), 70U);
  for (std::size_t i = 0; i < some.size(); ++i) {
    const RayBundle& same = all[i * all.size() / some.size()];
    EXPECT_EQ(some[i].key, same.key);
    EXPECT_EQ(some[i].points.mean, same.points.mean);
    EXPECT_EQ(some[i].points.covariance, same.points.covariance);
  }
  EXPECT_EQ(condense(scan, T_map_sensor, VoxelGrid{0.4}, {}, all.size()).bundles().size(), all.size());
}

}  // namespace
}  // namespace evermap
