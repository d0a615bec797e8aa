// SPDX-FileCopyrightText: 2026 the evermap authors
// SPDX-License-Identifier: BSD-3-Clause
#include <cmath>
#include <support/random_geometry.hpp>
#include <vector>

#include <Eigen/Eigenvalues>
#include <Eigen/LU>
#include <gtest/gtest.h>

#include <evermap/geometry/gaussian.hpp>

namespace evermap {
namespace {

using Eigen::Matrix3d;
using Eigen::Vector3d;
using test::Random;
using PointSet = std::vector<Vector3d>;

struct WeightedPoint {
  Vector3d p;
  double weight;
};

/// Mean and covariance in two passes of long double.
Gaussian moments(const std::vector<WeightedPoint>& points) {
  using Vector = Eigen::Matrix<long double, 3, 1>;
  long double weight = 0;
  Vector sum = Vector::Zero();
  for (const auto& [p, w] : points) {
    weight += w;
    sum += static_cast<long double>(w) * p.cast<long double>();
  }
  const Vector mean = sum / weight;
  Eigen::Matrix<long double, 3, 3> scatter = Eigen::Matrix<long double, 3, 3>::Zero();
  for (const auto& [p, w] : points) {
    const Vector from_mean = p.cast<long double>() - mean;
    scatter += static_cast<long double>(w) * from_mean * from_mean.transpose();
  }
  return {mean.cast<double>(), (scatter / weight).cast<double>(), static_cast<double>(weight)};
}

Gaussian moments(const PointSet& points) {
  std::vector<WeightedPoint> weighted;
  for (const Vector3d& p : points) weighted.push_back({p, 1});
  return moments(weighted);
}

PointSet random_points(Random& random, int count) {
  const Vector3d center = random.in_cube(5);
  const Matrix3d spread = random.rotation() * Vector3d(random.log_uniform(1e-3, 1), 0.2, 0.5).asDiagonal();
  PointSet points;
  for (int i = 0; i < count; ++i) points.emplace_back(center + spread * random.normal3());
  return points;
}

void expect_near(const Gaussian& actual, const Gaussian& expected, double tolerance) {
  const double scale = 1 + expected.mean.norm();
  EXPECT_LE((actual.mean - expected.mean).norm(), tolerance * scale);
  EXPECT_LE((actual.covariance - expected.covariance).norm(),
            tolerance * (expected.covariance.trace() + scale * 1e-6));
  EXPECT_NEAR(actual.count, expected.count, tolerance * expected.count);
}

TEST(Merge, EqualsTheMomentsOfAllPoints) {
  Random random(1);
  for (int i = 0; i < 1000; ++i) {
    const PointSet a = random_points(random, random.integer(1, 40));
    const PointSet b = random_points(random, random.integer(1, 40));
    PointSet both = a;
    both.insert(both.end(), b.begin(), b.end());
    expect_near(merge(moments(a), moments(b)), moments(both), 1e-10);
  }
}

TEST(Merge, CommutesAndKeepsTheCovarianceSymmetric) {
  Random random(2);
  for (int i = 0; i < 1000; ++i) {
    const Gaussian a{random.in_cube(3), random.covariance(0.001, 1), random.log_uniform(0.1, 1000)};
    const Gaussian b{random.in_cube(3), random.covariance(0.001, 1), random.log_uniform(0.1, 1000)};
    const Gaussian ab = merge(a, b);
    expect_near(ab, merge(b, a), 1e-12);
    EXPECT_LE((ab.covariance - ab.covariance.transpose()).norm(), 1e-15 * ab.covariance.trace());
  }
}

/// Seven sigma points on the 95 % ellipsoid, weighted so that they have the moments of the Gaussian.
std::vector<WeightedPoint> sigma_points(const Gaussian& gaussian) {
  const Eigen::SelfAdjointEigenSolver<Matrix3d> eigen(gaussian.covariance);
  const double weight = gaussian.count / (2 * kChiSquared95);
  std::vector<WeightedPoint> points{{gaussian.mean, gaussian.count - 6 * weight}};
  for (int axis = 0; axis < 3; ++axis) {
    const Vector3d offset =
        std::sqrt(kChiSquared95 * eigen.eigenvalues()[axis]) * eigen.eigenvectors().col(axis);
    points.push_back({gaussian.mean + offset, weight});
    points.push_back({gaussian.mean - offset, weight});
  }
  return points;
}

TEST(Merge, EqualsTheMomentsOfFourteenSigmaPoints) {
  Random random(3);
  for (int i = 0; i < 2000; ++i) {
    const Gaussian a{random.in_cube(1), random.covariance(0.01, 0.3), random.log_uniform(0.5, 1000)};
    const Gaussian b{a.mean + random.in_cube(0.5), random.covariance(0.01, 0.3),
                     random.log_uniform(0.5, 1000)};
    auto points = sigma_points(a);
    for (const auto& point : sigma_points(b)) points.push_back(point);
    const Gaussian merged = merge(a, b);
    const Gaussian expected = moments(points);
    EXPECT_LE((merged.mean - expected.mean).norm(), 1e-12 * expected.mean.norm());
    EXPECT_LE((merged.covariance - expected.covariance).norm(), 1e-12 * expected.covariance.trace());
    EXPECT_NEAR(merged.count / expected.count, 1, 1e-12);
  }
}

TEST(Remove, EqualsTheMomentsOfTheRemainingPoints) {
  Random random(4);
  for (int i = 0; i < 1000; ++i) {
    const PointSet rest = random_points(random, random.integer(4, 40));
    const PointSet part = random_points(random, random.integer(1, 40));
    PointSet all = rest;
    all.insert(all.end(), part.begin(), part.end());
    const auto found = remove(moments(all), moments(part));
    ASSERT_TRUE(found);
    // What is left is a small difference of larger numbers.
    const double magnified = moments(all).covariance.trace() / moments(rest).covariance.trace() + 1;
    expect_near(*found, moments(rest), 1e-13 * magnified * static_cast<double>(all.size()));
  }
}

TEST(Remove, UndoesMerge) {
  Random random(5);
  for (int i = 0; i < 2000; ++i) {
    const Gaussian a{random.in_cube(0.2), random.covariance(0.005, 0.2), random.log_uniform(1, 300)};
    const Gaussian b{random.in_cube(0.2), random.covariance(0.005, 0.2), random.log_uniform(1, 300)};
    const auto found = remove(merge(a, b), b);
    ASSERT_TRUE(found);
    expect_near(*found, a, 1e-12 * (a.count + b.count) / a.count * (1 + 0.25 / a.covariance.trace()));
  }
}

TEST(Remove, OfAllOrMoreThanThereIsLeavesNone) {
  const Gaussian all{Vector3d(1, 2, 3), Matrix3d::Identity(), 10};
  EXPECT_FALSE(remove(all, all));
  EXPECT_FALSE(remove(all, {all.mean, 0.5 * all.covariance, 10.001}));
  EXPECT_FALSE(remove(all, {all.mean, 0.5 * all.covariance, 1000}));
}

TEST(Remove, OfWhatIsNoSubsetLeavesNone) {
  const Gaussian all{Vector3d(1, 2, 3), Matrix3d::Identity(), 10};
  EXPECT_FALSE(remove(all, {all.mean, 4 * all.covariance, 5}));                        // too wide
  EXPECT_FALSE(remove(all, {all.mean + Vector3d(5, 0, 0), 0.1 * all.covariance, 5}));  // too far
  EXPECT_TRUE(remove(all, {all.mean + Vector3d(0.5, 0, 0), 0.1 * all.covariance, 5}));
}

TEST(Remove, LeavesASinglePoint) {
  Random random(6);
  const PointSet part = random_points(random, 20);
  PointSet all = part;
  all.emplace_back(part[0] + Vector3d(0.1, 0.2, 0.3));
  const auto found = remove(moments(all), moments(part));
  ASSERT_TRUE(found);
  EXPECT_LE((found->mean - all.back()).norm(), 1e-12);
  EXPECT_LE(found->covariance.norm(), 1e-9);
}

TEST(MahalanobisSquared, CountsStandardDeviationsAlongTheAxes) {
  Random random(7);
  for (int i = 0; i < 500; ++i) {
    const Matrix3d axes = random.rotation();
    const Vector3d sigma(random.log_uniform(0.002, 1), 0.1, 0.3);
    const Gaussian gaussian{random.in_cube(5), axes * sigma.cwiseAbs2().asDiagonal() * axes.transpose(), 3};
    const Vector3d steps = 3 * random.normal3();
    const Vector3d x = gaussian.mean + axes * sigma.cwiseProduct(steps);
    EXPECT_NEAR(mahalanobis_squared(x, gaussian) / steps.squaredNorm(), 1, 1e-8);
  }
}

TEST(MahalanobisSquared, QuantilesHoldTheirShareOfTheMass) {
  Random random(8);
  int in95 = 0, in99 = 0;
  const int samples = 400000;
  for (int i = 0; i < samples; ++i) {
    const double squared = mahalanobis_squared(random.normal3(), {Vector3d::Zero(), Matrix3d::Identity(), 1});
    in95 += squared <= kChiSquared95;
    in99 += squared <= kChiSquared99;
  }
  EXPECT_NEAR(in95 / static_cast<double>(samples), 0.95, 1.5e-3);
  EXPECT_NEAR(in99 / static_cast<double>(samples), 0.99, 7e-4);
}

TEST(KlDivergence, IsZeroOnlyForEqualDistributions) {
  Random random(9);
  for (int i = 0; i < 2000; ++i) {
    const Gaussian p{random.in_cube(1), random.covariance(0.01, 0.5), 3};
    const Gaussian q{random.in_cube(1), random.covariance(0.01, 0.5), 3};
    EXPECT_NEAR(kl_divergence(p, p), 0, 1e-9);
    EXPECT_GT(kl_divergence(p, q), 0);
  }
}

/// Independent axes: the sum of three one-dimensional divergences, here by numerical integration.
TEST(KlDivergence, EqualsTheIntegralOfItsDefinition) {
  const Vector3d p_mean(0.3, -0.2, 0.1), q_mean(0, 0.4, -0.5);
  const Vector3d p_sigma(0.5, 1.5, 0.9), q_sigma(1.1, 0.7, 2);
  double sum = 0;
  for (int axis = 0; axis < 3; ++axis) {
    const auto log_density = [](double x, double mean, double sigma) {
      return -0.5 * std::pow((x - mean) / sigma, 2) - std::log(sigma) - 0.5 * std::log(2 * std::acos(-1.0));
    };
    const int steps = 20000;
    const double width = 24 * p_sigma[axis] / steps;
    for (int i = 0; i < steps; ++i) {
      const double x = p_mean[axis] - 12 * p_sigma[axis] + (i + 0.5) * width;
      const double log_p = log_density(x, p_mean[axis], p_sigma[axis]);
      sum += std::exp(log_p) * (log_p - log_density(x, q_mean[axis], q_sigma[axis])) * width;
    }
  }
  const Matrix3d axes = Random(10).rotation();
  const Gaussian p{axes * p_mean, axes * p_sigma.cwiseAbs2().asDiagonal() * axes.transpose(), 1};
  const Gaussian q{axes * q_mean, axes * q_sigma.cwiseAbs2().asDiagonal() * axes.transpose(), 1};
  EXPECT_NEAR(kl_divergence(p, q), sum, 1e-9 * sum);
}

TEST(FloorEigenvalues, RaisesThoseBelowAndKeepsTheAxes) {
  Random random(11);
  for (int i = 0; i < 2000; ++i) {
    const Matrix3d axes = random.rotation();
    const Vector3d variances(random.log_uniform(1e-8, 1), random.log_uniform(1e-8, 1),
                             random.uniform(-1e-12, 1e-4));
    const double floor = random.log_uniform(1e-6, 1e-1);
    const Matrix3d floored = floor_eigenvalues(axes * variances.asDiagonal() * axes.transpose(), floor);
    const Matrix3d expected = axes * variances.cwiseMax(floor).asDiagonal() * axes.transpose();
    EXPECT_LE((floored - expected).norm(), 1e-12 * expected.trace());
  }
}

TEST(FloorEigenvalues, ReturnsTheVeryMatrixWhenNothingIsBelow) {
  const Matrix3d S = Random(12).covariance({0.1, 0.2, 0.3});
  EXPECT_EQ(floor_eigenvalues(S, 0.0099), S);
  EXPECT_NE(floor_eigenvalues(S, 0.0101), S);
  EXPECT_LE((floor_eigenvalues(Matrix3d::Zero(), 0.04) - 0.04 * Matrix3d::Identity()).norm(), 1e-17);
}

}  // namespace
}  // namespace evermap
