// SPDX-FileCopyrightText: 2026 the evermap authors
// SPDX-License-Identifier: BSD-3-Clause
#include <algorithm>
#include <cmath>
#include <limits>
#include <support/random_geometry.hpp>

#include <Eigen/Eigenvalues>
#include <gtest/gtest.h>

#include <evermap/update/detail/impact.hpp>

namespace evermap {
namespace {

using Eigen::Matrix3d;
using Eigen::Vector3d;
using test::Random;

double likelihood(const Approach& approach) { return std::exp(-0.5 * approach.mahalanobis_squared); }

/// The closest among points of the ray, not of the line behind the sensor; `reach` is a fraction of the ray.
Approach sampled_approach(const Ray& ray, const Gaussian& leaf, double reach, int samples) {
  Approach best{0, std::numeric_limits<double>::infinity()};
  for (int i = 0; i <= samples; ++i) {
    const double fraction = reach * i / samples;
    const double squared = mahalanobis_squared(ray.origin + fraction * (ray.end - ray.origin), leaf);
    if (squared < best.mahalanobis_squared) best = {fraction, squared};
  }
  return best;
}

TEST(ClosestApproach, EqualsTheBestOfDenseSamples) {
  Random random(6);
  for (int i = 0; i < 300; ++i) {
    const Vector3d origin = random.in_cube(5);
    const Vector3d u = random.direction();
    const Gaussian leaf{origin + random.uniform(1.5, 4) * u + random.in_cube(0.2),
                        random.covariance(0.03, 0.15), 5};
    const Ray ray{origin, origin + random.uniform(0.5, 9) * u};  // its end does not matter here
    const Approach found = closest_approach(ray, leaf);
    const Approach best = sampled_approach(ray, leaf, 6 / ray.length(), 20000);
    EXPECT_GE(likelihood(found), likelihood(best) * (1 - 1e-9));
    EXPECT_NEAR(likelihood(found), likelihood(best), 2e-5);
    if (likelihood(best) > 1e-3) {
      EXPECT_NEAR(found.fraction * ray.length(), best.fraction * ray.length(), 4e-4);
    }
  }
}

/// A ray begins at the sensor: what lies behind the sensor was not looked at.
TEST(ClosestApproach, StartsAtTheOrigin) {
  const Gaussian leaf{Vector3d(-0.3, 0, 0), 0.01 * Matrix3d::Identity(), 5};
  const Ray ray{Vector3d::Zero(), Vector3d(10, 0, 0)};
  const Approach found = closest_approach(ray, leaf);
  EXPECT_EQ(found.fraction, 0);
  EXPECT_NEAR(found.mahalanobis_squared, sampled_approach(ray, leaf, 1, 1000).mahalanobis_squared, 1e-9);
}

TEST(PlaneOf, FindsTheThinDirection) {
  Random random(7);
  for (int i = 0; i < 1000; ++i) {
    const Matrix3d axes = random.rotation();
    const double thin = random.uniform(0.002, 0.02);
    const double across = random.uniform(0.05, 0.1);
    const Vector3d variance(thin * thin, across * across, 0.0144);
    const Plane plane = plane_of({Vector3d(1, 2, 3), axes * variance.asDiagonal() * axes.transpose(), 5});
    EXPECT_TRUE(plane.flat);
    EXPECT_NEAR(std::abs(plane.normal.dot(axes.col(0))), 1, 1e-9);
    EXPECT_NEAR(plane.sigma / thin, 1, 1e-6);
  }
}

TEST(PlaneOf, IsWhatASolverForAllEigenvectorsSays) {
  Random random(8);
  for (int i = 0; i < 20000; ++i) {
    const Matrix3d axes = random.rotation();
    const auto variance = [&] { return std::pow(10.0, random.uniform(-6, -1)); };
    const Matrix3d diagonal = Vector3d(variance(), variance(), variance()).asDiagonal();
    const Matrix3d covariance = axes * diagonal * axes.transpose();
    const Gaussian leaf{Vector3d::Zero(), 0.5 * (covariance + covariance.transpose()), 5};
    const Eigen::SelfAdjointEigenSolver<Matrix3d> eigen(leaf.covariance);
    const Vector3d& values = eigen.eigenvalues();
    const Plane plane = plane_of(leaf);
    // [m^2] What rounding of the determinant comes to, in the smallest of its three factors.
    const double rounding = 1e-15 * values[2] * values[2] / values[1];
    if (std::abs(values[0] - 0.2 * values[1]) > 100 * rounding) {
      ASSERT_EQ(plane.flat, values[0] < 0.2 * values[1]) << values.transpose();
    }
    if (!plane.flat) continue;
    ASSERT_NEAR(plane.sigma * plane.sigma, values[0], 20 * rounding) << values.transpose();
    ASSERT_GT(std::abs(plane.normal.dot(eigen.eigenvectors().col(0))), 1 - 1e-9) << values.transpose();
  }
}

TEST(PlaneOf, IsFlatOnlyBelowAFifthOfTheMiddleVariance) {
  EXPECT_TRUE(plane_of({Vector3d::Zero(), Vector3d(0.0199, 0.1, 0.2).asDiagonal(), 5}).flat);
  EXPECT_FALSE(plane_of({Vector3d::Zero(), Vector3d(0.0201, 0.1, 0.2).asDiagonal(), 5}).flat);
  EXPECT_FALSE(plane_of({Vector3d::Zero(), Vector3d(0.01, 0.01, 0.2).asDiagonal(), 5}).flat);  // a pole
}

/// A patch of ground at the origin, 1 cm thick, and rays along x that pass it.
class DefaultImpact : public ::testing::Test {
 protected:
  DefaultImpact() {
    parameters_.extent_prior = 0;
    parameters_.patch_radius = 0;
  }

  double of(const Ray& ray, double free_fraction = 1, double error = 0) const {
    return JudgedLeaf(ground_, kEdge, error, parameters_)
        .impact(ray, 1e-4 * Matrix3d::Identity(), free_fraction);
  }

  static constexpr double kEdge = 0.4;  ///< [m]
  Gaussian ground_{Vector3d::Zero(), Vector3d(0.01, 0.01, 0.0001).asDiagonal(), 50};
  Ray through_{Vector3d(-6, 0, 2), Vector3d(3, 0, -1)};          ///< through the mean, ends 1 m below
  Ray grazing_{Vector3d(-10, 0, 0.02), Vector3d(10, 0, 0.015)};  ///< ends above the ground
  UpdateParameters parameters_;
};

TEST_F(DefaultImpact, IsOneThroughTheMean) { EXPECT_NEAR(of(through_), 1, 1e-12); }

TEST_F(DefaultImpact, RayThatEndsOnTheSameSideSaysNothing) {
  EXPECT_EQ(of(grazing_), 0);
  parameters_.surface_crossing = false;
  EXPECT_NEAR(of(grazing_), likelihood(closest_approach(grazing_, ground_)), 1e-12);
  EXPECT_GT(of(grazing_), 0.1);
}

TEST_F(DefaultImpact, RayMustEndThreeSigmaBeyondThePlane) {
  EXPECT_EQ(of({Vector3d(-6, 0, 0.06), Vector3d(2.9, 0, -0.029)}), 0);
  EXPECT_GT(of({Vector3d(-6, 0, 0.06), Vector3d(3.1, 0, -0.031)}), 0);
}

TEST_F(DefaultImpact, RayMustEndBeyondThePlaneByTheAlignmentErrorToo) {
  const double error = 0.1;
  const double beyond = 1;  // of through_, [m]
  parameters_.surface_tolerance = (beyond - 0.031) / error;
  EXPECT_NEAR(of(through_, 1, error), 1, 1e-12);
  parameters_.surface_tolerance = (beyond - 0.029) / error;
  EXPECT_EQ(of(through_, 1, error), 0);
}

TEST_F(DefaultImpact, LeafWithoutAPlaneMustStandAheadOfTheHitMargin) {
  const double error = 0.01;
  const double ahead = through_.length() / 3;  // from the mean to the end, [m]
  parameters_.hit_margin = 1.01 * ahead / error;
  EXPECT_NEAR(of(through_, 1, error), 1, 1e-12);  // a plane tells better
  ground_.covariance = 0.01 * Matrix3d::Identity();
  EXPECT_EQ(of(through_, 1, error), 0);
  parameters_.hit_margin = 0.99 * ahead / error;
  EXPECT_NEAR(of(through_, 1, error), 1, 1e-12);
}

TEST_F(DefaultImpact, CrossingIsAskedOfFlatLeavesOnly) {
  ground_.covariance(2, 2) = 0.005;
  EXPECT_NEAR(of(grazing_), likelihood(closest_approach(grazing_, ground_)), 1e-12);
  EXPECT_GT(of(grazing_), 0.9);
}

TEST_F(DefaultImpact, SmallImpactsAreIgnored) {
  const Ray beside{Vector3d(0.2, 0, 2), Vector3d(0.2, 0, -1)};  // 2 sigma off: exp(-2) = 0.135
  EXPECT_NEAR(of(beside), std::exp(-2), 1e-9);
  parameters_.least_impact = 0.14;
  EXPECT_EQ(of(beside), 0);
}

/// 0.15 m from a few points, in a voxel of 0.4 m, a surface may well be; 0.15 m from many, it is not.
TEST_F(DefaultImpact, FewPointsDoNotTellWhereALeafEnds) {
  const Ray beside{Vector3d(0.15, 0, 2), Vector3d(0.15, 0, -1)};
  ground_.covariance = Vector3d(4e-4, 4e-4, 1e-5).asDiagonal();
  EXPECT_EQ(of(beside), 0);  // 7.5 sigma
  parameters_.extent_prior = 1;
  ground_.count = 1;
  EXPECT_NEAR(of(beside), std::exp(-0.5 * 0.0225 / (4e-4 + 0.16 / 12 / 2)), 1e-9);
  ground_.count = 100;
  EXPECT_EQ(of(beside), 0);
}

/// A ray that misses a flat leaf along its plane does not come nearer because the leaf has few points.
TEST_F(DefaultImpact, WhereAFlatLeafLiesAcrossItsPlaneIsKnown) {
  parameters_.extent_prior = 8;
  parameters_.surface_crossing = false;
  ground_.count = 1;
  const Ray above{Vector3d(-10, 0, 0.05), Vector3d(10, 0, 0.05)};  // 5 sigma
  EXPECT_EQ(of(above), 0);
  ground_.covariance = 1e-4 * Matrix3d::Identity();
  EXPECT_GT(of(above), 0.5);
}

TEST_F(DefaultImpact, AFlatLeafCoversItsPlaneToThePatchRadius) {
  parameters_.patch_radius = 1.5;
  EXPECT_NEAR(of({Vector3d(0.14, 0, 2), Vector3d(0.14, 0, -1)}), 1, 1e-12);
  EXPECT_NEAR(of({Vector3d(0.2, 0, 2), Vector3d(0.2, 0, -1)}), std::exp(-0.5 * (4 - 2.25)), 1e-9);
  ground_.covariance = 0.01 * Matrix3d::Identity();
  EXPECT_NEAR(of({Vector3d(0.14, 0, 2), Vector3d(0.14, 0, -1)}), std::exp(-0.5 * 1.96), 1e-9);
}

TEST_F(DefaultImpact, SaysNothingBeyondTheFreeFraction) {
  const double to_mean = 6.0 / 9;
  EXPECT_EQ(of(through_, to_mean - 1e-6), 0);
  EXPECT_NEAR(of(through_, to_mean + 1e-6), 1, 1e-12);
}

}  // namespace
}  // namespace evermap
