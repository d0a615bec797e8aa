// SPDX-FileCopyrightText: 2026 the evermap authors
// SPDX-License-Identifier: BSD-3-Clause
#include <cmath>
#include <support/random_geometry.hpp>
#include <vector>

#include <Eigen/Eigenvalues>
#include <Eigen/LU>
#include <gtest/gtest.h>

#include <evermap/update/leaf_update.hpp>

namespace evermap {
namespace {

using Eigen::Matrix3d;
using Eigen::Vector3d;
using test::Random;

const Vector3d kCenter(10.1, -4.3, 2.5);  ///< [m] of the voxel under test

Gaussian bundle_near_center(Random& random, double count) {
  return {kCenter + random.in_cube(0.08), random.covariance(0.01, 0.06), count};
}

/// How often a new leaf must be hit until it is occupied.
int hits_until_occupied(const UpdateParameters& parameters) {
  Random random(1);
  Leaf leaf;
  for (int hits = 1; hits < 50; ++hits) {
    confirm(leaf, bundle_near_center(random, 5), kCenter, parameters);
    if (leaf.occupied()) return hits;
  }
  return -1;
}

TEST(Confirm, DefaultNeedsThreeHits) { EXPECT_EQ(hits_until_occupied({}), 3); }

TEST(Confirm, PaperNeedsOneHit) { EXPECT_EQ(hits_until_occupied(UpdateParameters::paper()), 1); }

/// For any size of the step, also such as are rounded up or down when stored as float.
TEST(Confirm, NeedsAsManyHitsAsAsked) {
  for (int confirmations = 1; confirmations <= 6; ++confirmations) {
    for (const double hit :
         {2.197, 0.1, 0.4, 0.405, 0.5, 0.6, 0.7, 0.8, 0.847, 0.85, 0.9, 1.0, 1.1, 1.386, 2.0, 2.2}) {
      UpdateParameters parameters;
      parameters.confirmations = confirmations;
      parameters.hit = hit;
      EXPECT_EQ(hits_until_occupied(parameters), confirmations) << "log-odds of one hit: " << hit;
    }
  }
}

TEST(Confirm, NewLeafBecomesTheBundle) {
  Random random(2);
  for (int i = 0; i < 200; ++i) {
    const Gaussian bundle = bundle_near_center(random, random.integer(1, 50));
    Leaf leaf;
    confirm(leaf, bundle, kCenter, {});
    const Gaussian surface = leaf.gaussian(kCenter);
    EXPECT_LE((surface.mean - bundle.mean).norm(), 2e-8);
    EXPECT_LE((surface.covariance - bundle.covariance).norm(), 1e-6 * bundle.covariance.trace());
    EXPECT_EQ(surface.count, bundle.count);
  }
}

TEST(Confirm, MergesAndCapsTheCount) {
  Random random(3);
  UpdateParameters parameters;
  parameters.max_count = 100;
  for (int i = 0; i < 200; ++i) {
    const Gaussian first = bundle_near_center(random, 80), second = bundle_near_center(random, 60);
    Leaf leaf;
    confirm(leaf, first, kCenter, parameters);
    confirm(leaf, second, kCenter, parameters);
    const Gaussian surface = leaf.gaussian(kCenter);
    const Gaussian expected = merge(first, second);
    EXPECT_LE((surface.mean - expected.mean).norm(), 3e-8);
    EXPECT_LE((surface.covariance - expected.covariance).norm(), 1e-6 * expected.covariance.trace());
    EXPECT_EQ(surface.count, 100);  // the cap limits the memory, not the weights of this union
  }
}

std::vector<float> log_odds_of_hits(const UpdateParameters& parameters, int hits) {
  Random random(4);
  Leaf leaf;
  std::vector<float> log_odds;
  for (int i = 0; i < hits; ++i) {
    confirm(leaf, bundle_near_center(random, 5), kCenter, parameters);
    log_odds.push_back(leaf.log_odds);
  }
  return log_odds;
}

TEST(Confirm, BeyondWhatAFewHitsTellLeavesGrowFirmSlowly) {
  const std::vector<float> expected{-2.197F, 0, 2.197F, 3, 4, 5, 6, 7, 8, 9, 9};
  const std::vector<float> found = log_odds_of_hits({}, 11);
  for (std::size_t i = 0; i < expected.size(); ++i) EXPECT_NEAR(found[i], expected[i], 1e-6) << i;
}

TEST(Confirm, AClampAboveTheFirmOneIsTheMost) {
  UpdateParameters parameters;
  parameters.max_log_odds = 12;
  EXPECT_FLOAT_EQ(log_odds_of_hits(parameters, 20).back(), 12);
}

TEST(Confirm, ThePapersLogOddsStopAtTheClamp) {
  EXPECT_FLOAT_EQ(log_odds_of_hits(UpdateParameters::paper(), 10).back(), 3.5F);
}

Leaf leaf_at(double log_odds) {
  Leaf leaf;
  leaf.set_gaussian({kCenter, 0.01 * Matrix3d::Identity(), 20}, kCenter);
  leaf.log_odds = static_cast<float>(log_odds);
  return leaf;
}

TEST(Contradict, ThreeFullContradictionsDeleteFromTheClamp) {
  for (const UpdateParameters& parameters : {UpdateParameters{}, UpdateParameters::paper()}) {
    Leaf leaf = leaf_at(parameters.max_log_odds);
    EXPECT_TRUE(contradict(leaf, 1, parameters));
    EXPECT_TRUE(contradict(leaf, 1, parameters));
    EXPECT_TRUE(leaf.occupied());
    EXPECT_FALSE(contradict(leaf, 1, parameters));
  }
}

TEST(Contradict, StepIsScaledByTheImpact) {
  const UpdateParameters parameters;
  for (const double impact : {0.1, 0.25, 0.5, 1.0}) {
    Leaf leaf = leaf_at(3.5);
    EXPECT_TRUE(contradict(leaf, impact, parameters));
    EXPECT_NEAR(static_cast<double>(leaf.log_odds), 3.5 - impact * parameters.miss, 1e-6);
    EXPECT_NEAR(static_cast<double>(leaf.count), 20 * (1 - impact / 2), 1e-5);
  }
}

TEST(Contradict, WithoutImpactNothingChanges) {
  for (const double log_odds : {3.5, 1e-3, 0.0, -2.0}) {
    Leaf leaf = leaf_at(log_odds);
    EXPECT_TRUE(contradict(leaf, 0, {}));
    EXPECT_EQ(leaf.log_odds, static_cast<float>(log_odds));
  }
}

TEST(Contradict, PendingLeafGoesBelowAFirstHit) {
  Random random(5);
  const UpdateParameters parameters;
  Leaf once;
  confirm(once, bundle_near_center(random, 5), kCenter, parameters);
  Leaf twice = once;
  confirm(twice, bundle_near_center(random, 5), kCenter, parameters);
  EXPECT_FALSE(twice.occupied());
  Leaf untouched = once;
  EXPECT_TRUE(contradict(untouched, 0, parameters));
  EXPECT_FALSE(contradict(once, 0.1, parameters));
  EXPECT_TRUE(contradict(twice, 1, parameters));  // still above the first hit
  EXPECT_FALSE(contradict(twice, 1, parameters));
}

std::vector<Vector3d> sigma_points(const Gaussian& leaf) {
  const Eigen::SelfAdjointEigenSolver<Matrix3d> eigen(leaf.covariance);
  std::vector<Vector3d> points{leaf.mean};
  for (int axis = 0; axis < 3; ++axis) {
    const Vector3d offset =
        std::sqrt(7.814727903251179 * eigen.eigenvalues()[axis]) * eigen.eigenvectors().col(axis);
    points.emplace_back(leaf.mean + offset);
    points.emplace_back(leaf.mean - offset);
  }
  return points;
}

TEST(SigmaPointDifference, EqualsAnIndependentRefit) {
  Random random(6);
  int refitted = 0, unchanged = 0, none = 0;
  for (int i = 0; i < 20000; ++i) {
    const Gaussian leaf{kCenter, random.covariance(0.01, 0.15), random.uniform(1, 100)};
    const Gaussian bundle{kCenter + random.in_cube(0.2), random.covariance(0.005, 0.15), 5};
    std::vector<Vector3d> kept;
    for (const Vector3d& p : sigma_points(leaf)) {
      const Vector3d apart = p - bundle.mean;
      if (apart.dot(bundle.covariance.ldlt().solve(apart)) > 7.814727903251179) kept.push_back(p);
    }
    const auto found = sigma_point_difference(leaf, bundle);
    ASSERT_EQ(found.has_value(), !kept.empty());
    ++(kept.empty() ? none : kept.size() == 7 ? unchanged : refitted);
    if (!found) continue;
    const auto k = static_cast<double>(kept.size());
    Vector3d mean = Vector3d::Zero();
    for (const Vector3d& p : kept) mean += (p - kCenter) / k;
    Matrix3d S = Matrix3d::Zero();
    for (const Vector3d& p : kept) S += (p - kCenter - mean) * (p - kCenter - mean).transpose() / k;
    S *= 7 / (2 * 7.814727903251179);  // so that all seven points give the leaf's own covariance
    EXPECT_LE((found->mean - kCenter - mean).norm(), 1e-13);
    EXPECT_LE((found->covariance - S).norm(), 1e-12 * leaf.covariance.trace());
    EXPECT_NEAR(found->count, leaf.count * k / 7, 1e-12 * leaf.count);
  }
  EXPECT_GT(refitted, 2000);
  EXPECT_GT(unchanged, 2000);
  EXPECT_GT(none, 20);
}

TEST(SigmaPointDifference, NothingInsideChangesNothing) {
  const Gaussian leaf{kCenter, Random(7).covariance({0.1, 0.05, 0.02}), 33};
  const auto found =
      sigma_point_difference(leaf, {kCenter + Vector3d(1, 0, 0), 1e-4 * Matrix3d::Identity(), 5});
  ASSERT_TRUE(found);
  EXPECT_EQ(found->mean, leaf.mean);
  EXPECT_EQ(found->covariance, leaf.covariance);
  EXPECT_EQ(found->count, leaf.count);
}

TEST(SigmaPointDifference, AllInsideLeavesNothing) {
  const Gaussian leaf{kCenter, Random(8).covariance({0.1, 0.05, 0.02}), 33};
  EXPECT_FALSE(sigma_point_difference(leaf, {kCenter, 0.0101 * Matrix3d::Identity(), 5}));
  EXPECT_TRUE(sigma_point_difference(leaf, {kCenter, 0.0099 * Matrix3d::Identity(), 5}));
}

/// Weighs samples of the leaf by what the cylinder around the ray leaves of them.
Gaussian sampled_difference(const Gaussian& leaf, const Ray& ray, const Gaussian& bundle, double rho,
                            int samples, Random& random) {
  const Vector3d u = (ray.end - ray.origin).normalized();
  const Vector3d e = u.unitOrthogonal();
  Eigen::Matrix<double, 3, 2> across;
  across << e, u.cross(e);
  const Eigen::Matrix2d information = (across.transpose() * bundle.covariance * across).inverse();
  const Matrix3d root = leaf.covariance.llt().matrixL();
  double weight = 0;
  Vector3d sum = Vector3d::Zero();
  Matrix3d squares = Matrix3d::Zero();
  const auto add = [&](const Vector3d& offset) {
    const Eigen::Vector2d lateral = across.transpose() * (leaf.mean + offset - ray.origin);
    const double w = 1 - rho * std::exp(-0.5 * lateral.dot(information * lateral));
    weight += w;
    sum += w * offset;
    squares += w * offset * offset.transpose();
  };
  for (int i = 0; i < samples; ++i) {
    const Vector3d offset = root * random.normal3();
    add(offset);
    add(-offset);
  }
  const Vector3d mean = sum / weight;
  return {leaf.mean + mean, squares / weight - mean * mean.transpose(), leaf.count * weight / (2 * samples)};
}

TEST(SoftDifference, EqualsMonteCarlo) {
  Random random(9);
  double most_taken = 0;
  for (int i = 0; i < 12; ++i) {
    const Gaussian leaf{kCenter, random.covariance(0.02, 0.15), 40};
    const Ray ray{kCenter + 5 * random.direction() + random.in_cube(0.1), kCenter - 3 * random.direction()};
    Ray through{ray.origin, kCenter + random.in_cube(0.1)};
    through.end += (through.end - through.origin);
    const Gaussian bundle{through.end, random.covariance(0.02, 0.15), 5};
    const double rho = i % 3 == 0 ? 1 : random.uniform(0.2, 1);
    const Gaussian found = soft_difference(leaf, through, bundle, rho);
    const Gaussian expected = sampled_difference(leaf, through, bundle, rho, 500000, random);
    const double sigma = std::sqrt(leaf.covariance.trace());
    EXPECT_LE((found.mean - expected.mean).norm(), 0.008 * sigma);
    EXPECT_LE((found.covariance - expected.covariance).norm(), 0.008 * leaf.covariance.trace());
    EXPECT_NEAR(found.count, expected.count, 0.004 * leaf.count);
    most_taken = std::max(most_taken, 1 - found.count / leaf.count);
  }
  EXPECT_GT(most_taken, 0.3);
}

TEST(SoftDifference, StaysPositiveSemiDefinite) {
  Random random(10);
  double most_taken = 0;
  int unchanged = 0;
  for (int i = 0; i < 20000; ++i) {
    const Gaussian leaf{kCenter, random.covariance(0.002, 0.15), 40};
    const Vector3d origin = kCenter + random.uniform(1, 20) * random.direction();
    const Ray ray{origin, kCenter + random.in_cube(0.2)};
    const Gaussian bundle{ray.end, random.covariance(0.002, i % 2 ? 0.15 : 2.0), 5};
    const double rho = i % 4 == 0 ? 1 : random.uniform(0, 1);
    const Gaussian rest = soft_difference(leaf, ray, bundle, rho);
    ASSERT_TRUE(rest.mean.allFinite() && rest.covariance.allFinite());
    const Eigen::SelfAdjointEigenSolver<Matrix3d> eigen(rest.covariance);
    ASSERT_GE(eigen.eigenvalues().minCoeff(), -1e-9 * eigen.eigenvalues().maxCoeff());
    ASSERT_TRUE(rest.count > 0 && rest.count <= leaf.count);
    most_taken = std::max(most_taken, 1 - rest.count / leaf.count);
    unchanged += rest.count == leaf.count;
  }
  EXPECT_GT(most_taken, 0.9);
  EXPECT_LT(unchanged, 4000);  // beside the cylinder nothing is taken, but most rays take something
}

TEST(SoftDifference, TakesNothingForNoImpact) {
  Random random(11);
  const Gaussian leaf{kCenter, random.covariance(0.02, 0.15), 40};
  const Ray ray{kCenter + Vector3d(5, 0, 0), kCenter - Vector3d(1, 0, 0)};
  const Gaussian rest = soft_difference(leaf, ray, {ray.end, 0.01 * Matrix3d::Identity(), 5}, 0);
  EXPECT_LE((rest.mean - leaf.mean).norm(), 1e-15);
  EXPECT_LE((rest.covariance - leaf.covariance).norm(), 1e-15);
  EXPECT_EQ(rest.count, leaf.count);
}

/// A ray along x through the mean takes the middle: what is left is wider across the ray, and as long.
TEST(SoftDifference, LeavesTheRimOfThePatch) {
  const Gaussian leaf{kCenter, 0.01 * Matrix3d::Identity(), 40};
  const Ray ray{kCenter + Vector3d(5, 0, 0), kCenter - Vector3d(1, 0, 0)};
  const Gaussian rest = soft_difference(leaf, ray, {ray.end, 0.01 * Matrix3d::Identity(), 5}, 1);
  EXPECT_NEAR(rest.count, 20, 1e-12);  // c = sqrt(s^4 / (2 s^2)^2) = 1/2
  EXPECT_LE((rest.mean - leaf.mean).norm(), 1e-14);
  // (s^2 - c s^2 / 2) / (1 - c) = 1.5 s^2 across
  EXPECT_LE((rest.covariance - Matrix3d(Vector3d(0.01, 0.015, 0.015).asDiagonal())).norm(), 1e-14);
}

}  // namespace
}  // namespace evermap
