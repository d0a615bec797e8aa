// SPDX-FileCopyrightText: 2026 the evermap authors
// SPDX-License-Identifier: BSD-3-Clause
#include <algorithm>
#include <cmath>
#include <limits>
#include <optional>
#include <span>

#include <Eigen/LU>
#include <gtest/gtest.h>
#include <oneapi/tbb/global_control.h>
#include <oneapi/tbb/task_arena.h>

#include "localization/worlds.hpp"
#include "support/random_geometry.hpp"
#include <evermap/localization/detail/correspondence.hpp>
#include <evermap/localization/detail/perturbation.hpp>
#include <evermap/localization/detail/registration.hpp>

namespace evermap {
namespace {

/// The yard as it was surveyed, and scans of it as it is now.
struct YardNow {
  Octree map = test::survey_map(test::yard().survey_scene(), 0.4);
  Simulator now{test::yard().scene(0)};
  Scan scan(std::size_t i) const { return now.scan(test::yard().T_map_sensor(i), test::small_lidar(), i); }
};
const YardNow& yard_now() {
  static const YardNow yard;
  return yard;
}

Registration register_fine(const Octree& map, const Scan& scan, const Pose& guess) {
  const auto bundles = bundles_in_sensor_frame(scan, map.grid().edge, {});
  return register_bundles(map, bundles, {guess}, {});
}

Pose shaken(const Pose& pose, double translation, double rotation, test::Random& random) {
  Twist twist;
  twist << translation * std::cbrt(random.uniform(0, 1)) * random.direction(),
      rotation * random.uniform(0, 1) * random.direction();
  return perturb(pose, twist);
}

/// Whether another face that a sensor at the origin sees stands before this leaf's, two voxels off at most.
bool is_hidden(const Octree& map, VoxelKey key, const Eigen::Vector3d& normal) {
  const Gaussian face = map.gaussian(key, *map.find(key));
  const Eigen::Vector3d towards = normal.dot(face.mean) > 0 ? -normal : normal;
  const double thick = std::sqrt(normal.dot(face.covariance * normal));
  for (const double step : {1, 2}) {
    const auto before = map.grid().key(face.mean + step * map.grid().edge * towards);
    const Leaf* leaf = before ? map.find(*before) : nullptr;
    if (leaf == nullptr || !leaf->occupied()) continue;
    const Gaussian other = map.gaussian(*before, *leaf);
    const double other_thick = std::sqrt(normal.dot(other.covariance * normal));
    const bool are_thin = std::max(thick, other_thick) < map.grid().edge / 8;
    if (are_thin && towards.dot(other.mean - face.mean) > 4 * (thick + other_thick)) return true;
  }
  return false;
}

// Plain and slow: all leaves of the map are looked at, and everything is written out by the formulas.
TEST(Correspondence, IsTheNearestOfTheVoxelsThatAreAsked) {
  const Octree& map = yard_now().map;
  const Pose T = test::yard().T_map_sensor(3);
  test::Random random(5);
  const auto bundles = bundles_in_sensor_frame(yard_now().scan(3), 0.4, {}, 200);
  std::size_t matched = 0;
  std::size_t hidden = 0;
  for (const Gaussian& bundle_sensor : bundles) {
    const Gaussian bundle{T * bundle_sensor.mean + random.in_cube(0.3),
                          T.rotation * bundle_sensor.covariance * T.rotation.transpose(), 1};
    const Eigen::Vector3i voxel = *map.grid().voxel(bundle.mean);
    const Eigen::Vector3d in_voxel = bundle.mean - map.grid().center(VoxelKey::from_voxel(voxel));
    const bool is_own_there = map.find(VoxelKey::from_voxel(voxel)) != nullptr;
    double best = std::numeric_limits<double>::infinity();
    Eigen::Matrix3d best_information = Eigen::Matrix3d::Zero();
    std::optional<VoxelKey> best_key;
    const auto look = [&](double least, std::optional<VoxelKey> but) {
      best = std::numeric_limits<double>::infinity();
      best_key.reset();
      map.for_each_leaf([&](VoxelKey key, const Leaf& leaf) {
        const Eigen::Vector3i step = key.voxel() - voxel;
        const double towards = step.cast<double>().dot(in_voxel);  // [m] 0.2 from the centre is the face
        const bool is_asked = step.isZero() || towards >= least;
        if (!leaf.occupied() || step.cwiseAbs().sum() > 1 || !is_asked || key == but) return;
        const Gaussian surface = map.gaussian(key, leaf);
        const Eigen::Matrix3d M = (surface.covariance + bundle.covariance).inverse();
        const double d2 = (surface.mean - bundle.mean).dot(M * (surface.mean - bundle.mean));
        if (d2 >= best) return;
        best_information = M;
        best = d2;
        best_key = key;
      });
      if (best_key && is_hidden(map, *best_key, stiffest_axis(best_information))) {
        best = std::numeric_limits<double>::infinity();
      }
    };
    look(is_own_there ? 0.12 : 0, std::nullopt);
    if (best_key && !std::isfinite(best)) {
      look(0, best_key);
      ++hidden;
    }
    const auto matches = correspond(map, std::span(&bundle, 1), Pose{});
    ASSERT_EQ(matches[0].has_value(), std::isfinite(best));
    if (!matches[0].has_value()) continue;
    ++matched;
    EXPECT_NEAR(matches[0]->mahalanobis_squared, best, 1e-9 * (1 + best));
    EXPECT_LT((matches[0]->information - best_information).norm(), 1e-9 * best_information.norm());
  }
  EXPECT_GT(matched, 100U);
  EXPECT_GT(hidden, 5U);
}

TEST(Registration, FindsThePoseFromCloseBy) {
  test::Random random(6);
  for (std::size_t i = 0; i < 10; ++i) {
    const Pose truth = test::yard().T_map_sensor(6 * i);
    const Registration found =
        register_fine(yard_now().map, yard_now().scan(6 * i), shaken(truth, 0.2, kDegree, random));
    EXPECT_TRUE(found.converged()) << to_string(found.reject_reason);
    const Twist off = difference(truth, found.T_map_sensor);
    EXPECT_LT(off.head<3>().norm(), 0.01);
    EXPECT_LT(off.tail<3>().norm(), 0.1 * kDegree);
    EXPECT_GT(found.inlier_fraction, 0.8);
  }
}

TEST(Registration, FindsThePoseFromAMetreAndTenDegrees) {
  test::Random random(7);
  int missed = 0;
  for (std::size_t i = 0; i < 50; ++i) {
    const Pose truth = test::yard().T_map_sensor(i);
    const Registration found = register_coarse_to_fine(yard_now().map, yard_now().scan(i),
                                                       {shaken(truth, 1, 10 * kDegree, random)}, {}, {});
    const Twist off = difference(truth, found.T_map_sensor);
    const bool is_there = off.head<3>().norm() < 0.01 && off.tail<3>().norm() < 0.1 * kDegree;
    missed += !(is_there && found.converged());
  }
  EXPECT_EQ(missed, 0);
}

// All bundles are where their leaves are, so that none is off by more than is usual.
TEST(Registration, AMapOfTheSameScanHoldsItWhereItIs) {
  Octree map(VoxelGrid{.edge = 0.4});
  const Scan scan = yard_now().scan(0);
  add_cloud(map, scan, Pose{}, {}, {});
  const Registration found = register_fine(map, scan, Pose{});
  EXPECT_TRUE(found.converged());
  EXPECT_LT(difference(Pose{}, found.T_map_sensor).norm(), 1e-3);
}

TEST(Registration, AnyNumberOfThreadsGivesTheSameBytes) {
  test::Random random(8);
  const Scan scan = yard_now().scan(0);
  const Pose guess = shaken(test::yard().T_map_sensor(0), 0.5, 5 * kDegree, random);
  const auto with_threads = [&](int threads) {
    const oneapi::tbb::global_control limit(oneapi::tbb::global_control::max_allowed_parallelism,
                                            static_cast<std::size_t>(threads));
    oneapi::tbb::task_arena arena(threads);
    return arena.execute([&] { return register_coarse_to_fine(yard_now().map, scan, {guess}, {}, {}); });
  };
  const Registration one = with_threads(1);
  for (const int threads : {2, 3, 8}) {
    const Registration many = with_threads(threads);
    EXPECT_EQ(one.T_map_sensor.rotation, many.T_map_sensor.rotation);
    EXPECT_EQ(one.T_map_sensor.translation, many.T_map_sensor.translation);
    EXPECT_EQ(one.covariance, many.covariance);
    EXPECT_EQ(one.residual, many.residual);
    EXPECT_EQ(one.unobservable, many.unobservable);
  }
}

// A leaf that holds both faces of such a wall is wider across the wall than along it, as if a wall stood
// across.
TEST(Registration, AWallAsThickAsItsLeavesTellsNothingAlongItself) {
  for (const double thickness : {0.2, 0.25, 0.3, 0.35}) {
    Scene scene;
    Pose T_map_wall;
    T_map_wall.translation.y() = 1.4;  // the middle of a row of voxels
    add_box(scene, 1, T_map_wall, {20, thickness, 4});
    const Octree map = test::survey_map(scene, 0.4, 0.05);
    std::vector<Gaussian> bundles;
    for (double x = -8; x < 8; x += 0.03) {
      const double z = 1.5 * std::sin(7 * x);
      bundles.push_back({{x, 1.4 - thickness / 2, z}, 2e-4 * Eigen::Matrix3d::Identity(), 1});
    }
    const NormalEquations equations = equations_at(map, bundles, Pose{}, RobustKernel{6});
    EXPECT_GT(equations.matched, 400U);
    constexpr double kVague = 0.3;  // [m] of one bundle
    EXPECT_LT(equations.hessian(0, 0) * kVague * kVague, static_cast<double>(equations.matched)) << thickness;
  }
}

// From a place where the ends of a corridor fit by chance, registration goes on to where they fit best.
TEST(Registration, GoesOnAlongACorridorUntilItsEndsFitBest) {
  Scene scene;
  add_box(scene, 1, Pose{}, {30, 3, 2.6});  // seen from within
  for (const double x : {-14.6, 14.7}) {    // a second end before each
    Pose T_map_end;
    T_map_end.translation.x() = x;
    add_box(scene, 2, T_map_end, {0.02, 1.2, 2.6});
  }
  const Octree map = test::survey_map(scene, 0.2, 0.05);
  const Scan scan = Simulator(scene).scan(Pose{}, test::small_lidar(), 1);
  for (const double off : {-0.5, -0.4, -0.3, 0.3, 0.4, 0.5}) {
    Pose guess;
    guess.translation.x() = off;
    const Registration found = register_fine(map, scan, guess);
    EXPECT_TRUE(found.converged());
    EXPECT_LT(found.T_map_sensor.translation.norm(), 0.01) << off;
  }
}

class Degenerate : public ::testing::TestWithParam<double> {};

TEST_P(Degenerate, AnEndlessCorridorHoldsNothingAlongIt) {
  for (const double yaw : {0.0, 0.6}) {
    const Scene scene = test::corridor(yaw);
    const Octree map = test::survey_map(scene, GetParam());
    Pose guess;
    guess.translation.x() = 0.1;
    const Registration found =
        register_fine(map, Simulator(scene).scan(Pose{}, test::small_lidar(), 1), guess);
    EXPECT_TRUE(found.converged()) << to_string(found.reject_reason);
    EXPECT_EQ(found.unobservable, 1);
    const Eigen::Vector3d along(std::cos(yaw), std::sin(yaw), 0);
    const WeakestDirection weakest = weakest_direction(found.covariance);
    EXPECT_FALSE(weakest.is_rotation);
    EXPECT_GT(std::abs(weakest.axis.dot(along)), 0.99);
    EXPECT_NEAR(weakest.sigma, 0.5, 0.01) << "what was known before";
    // There it stays where it was guessed; across, it finds the walls.
    const Eigen::Vector3d& p = found.T_map_sensor.translation;
    EXPECT_NEAR(p.dot(along), guess.translation.dot(along), 0.005);
    EXPECT_LT((p - p.dot(along) * along).norm(), 0.005);
  }
}

TEST_P(Degenerate, APlaneHoldsNoTurnAboutItsNormal) {
  const Scene scene = test::plane();
  const Registration found = register_fine(test::survey_map(scene, GetParam()),
                                           Simulator(scene).scan(Pose{}, test::small_lidar(), 1), Pose{});
  EXPECT_EQ(found.unobservable, 3);
  EXPECT_EQ(to_string(weakest_direction(found.covariance)), "rotation about z");
}

INSTANTIATE_TEST_SUITE_P(Edges, Degenerate, ::testing::Values(0.2, 0.4, 0.8));

TEST(Registration, OfNextToNothingDoesNotConverge) {
  const Scan scan = yard_now().scan(0);
  const Pose truth = test::yard().T_map_sensor(0);
  const auto outcome = [&](const Octree& map, const Scan& points, const Pose& guess) {
    const Registration coarse = register_coarse_to_fine(map, points, {guess}, {}, {});
    EXPECT_FALSE(coarse.converged());
    EXPECT_TRUE(coarse.T_map_sensor.translation.allFinite());
    return register_fine(map, points, guess).reject_reason;
  };
  EXPECT_EQ(outcome(yard_now().map, Scan{}, truth), RejectReason::kTooFewBundles);
  Scan five;
  five.p_sensor.assign(scan.p_sensor.begin(), scan.p_sensor.begin() + 5);
  EXPECT_EQ(outcome(yard_now().map, five, truth), RejectReason::kTooFewBundles);
  Scan heap_of_points;
  heap_of_points.p_sensor.assign(5000, {5, 0, 0});
  EXPECT_EQ(outcome(yard_now().map, heap_of_points, truth), RejectReason::kTooFewBundles);
  EXPECT_EQ(outcome(Octree(VoxelGrid{0.4}), scan, truth), RejectReason::kTooFewMatches);
  Pose far = truth;
  far.translation.x() += 1000;
  EXPECT_EQ(outcome(yard_now().map, scan, far), RejectReason::kTooFewMatches);
  far.translation.x() = 1e12;  // beyond the range of keys
  EXPECT_EQ(outcome(yard_now().map, scan, far), RejectReason::kTooFewMatches);
}

}  // namespace
}  // namespace evermap
