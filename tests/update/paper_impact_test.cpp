// SPDX-FileCopyrightText: 2026 the evermap authors
// SPDX-License-Identifier: BSD-3-Clause
#include <algorithm>
#include <cmath>
#include <limits>
#include <support/encounter.hpp>
#include <support/random_geometry.hpp>

#include <Eigen/Eigenvalues>
#include <gtest/gtest.h>

#include <evermap/update/detail/impact.hpp>
#include <evermap/update/detail/paper_impact.hpp>

namespace evermap {
namespace {

using Eigen::Matrix3d;
using Eigen::Vector3d;
using test::Encounter;
using test::golden_section;
using test::Random;
using test::random_encounter;
using test::travelling;
using test::TravellingDivergence;

/// The divergence has two directions; equation 3 is the minimum of D(travelling bundle || leaf).
TEST(ClosestResemblance, MinimizesTheDivergenceFromTheBundleToTheLeaf) {
  Random random(1);
  int inner = 0;
  int reverse_not_minimal = 0;
  for (int i = 0; i < 2000; ++i) {
    Encounter e = random_encounter(random);
    e.leaf.covariance = random.covariance(0.01, 0.15);
    e.leaf.mean = e.ray.origin + random.uniform(0.2, 0.8) * (e.ray.end - e.ray.origin) + random.in_cube(0.2);
    const double t = closest_resemblance(e.ray, e.bundle.covariance, e.leaf);
    if (t >= 0.99) continue;
    ++inner;
    const double least = kl_divergence(travelling(e, t), e.leaf);
    const double reverse = kl_divergence(e.leaf, travelling(e, t));
    bool reverse_is_minimal = true;
    for (const double nearby : {0.99 * t, 1.01 * t}) {
      EXPECT_GT(kl_divergence(travelling(e, nearby), e.leaf), least);
      if (kl_divergence(e.leaf, travelling(e, nearby)) < reverse) reverse_is_minimal = false;
    }
    reverse_not_minimal += !reverse_is_minimal;
  }
  EXPECT_GT(inner, 1000);
  EXPECT_GT(reverse_not_minimal, inner / 4);
}

TEST(ClosestResemblance, ReferenceAgreesWithItsOwnDivergence) {
  Random random(2);
  for (int i = 0; i < 1000; ++i) {
    const Encounter e = random_encounter(random);
    const TravellingDivergence f(e);
    const long double t = f.minimum();
    // A minimum by values alone is known to half the digits of the divergence, which is up to 1e10 here.
    EXPECT_NEAR(static_cast<double>(golden_section(f, t / 3, 3 * t) / t), 1, 3e-4);
    EXPECT_NEAR(static_cast<double>(f(0.7L)) / kl_divergence(travelling(e, 0.7), e.leaf), 1, 1e-6);
  }
}

TEST(ClosestResemblance, EqualsTheNumericalMinimum) {
  Random random(3);
  int clamped = 0;
  int inner = 0;
  double worst = 0;
  for (int i = 0; i < 100000; ++i) {
    const Encounter e = random_encounter(random);
    const double t = closest_resemblance(e.ray, e.bundle.covariance, e.leaf);
    const auto expected = static_cast<double>(std::min(1.0L, TravellingDivergence(e).minimum()));
    ASSERT_GT(t, 0);
    ASSERT_LE(t, 1);
    worst = std::max(worst, std::abs(t - expected) / expected);
    ++(expected == 1 ? clamped : inner);
  }
  EXPECT_LT(worst, 1e-8);
  EXPECT_GT(clamped, 10000);
  EXPECT_GT(inner, 10000);
}

/// A leaf behind the sensor, or a bundle far wider than its leaf: the root must not cancel to zero.
TEST(ClosestResemblance, SurvivesLargePositiveLinearTerms) {
  for (const double behind : {0.1, 1.0, 100.0, 1e4}) {
    Encounter e{{Vector3d::Zero(), Vector3d(20, 0, 0)}, {}, {}};
    e.bundle = {e.ray.end, 0.01 * Matrix3d::Identity(), 5};
    e.leaf = {Vector3d(-behind, 0, 0), 1e-6 * Matrix3d::Identity(), 5};
    const double t = closest_resemblance(e.ray, e.bundle.covariance, e.leaf);
    const auto expected = static_cast<double>(TravellingDivergence(e).minimum());
    EXPECT_NEAR(t / expected, 1, 1e-10);
  }
}

TEST(BundleAt, TravelsFromTheOriginAndWidens) {
  const Ray ray{Vector3d(1, 2, 3), Vector3d(5, 2, 3)};
  const Gaussian half = bundle_at(0.25, ray, Vector3d(1, 2, 3).asDiagonal());
  EXPECT_TRUE(half.mean.isApprox(Vector3d(2, 2, 3)));
  EXPECT_TRUE(half.covariance.isApprox(Matrix3d(Vector3d(0.25, 0.5, 0.75).asDiagonal())));
}

TEST(DensestOverlap, MaximizesTheProductOfBothDensities) {
  Random random(4);
  for (int i = 0; i < 1000; ++i) {
    const Gaussian leaf{random.in_cube(10), random.covariance(0.01, 0.3), 5};
    const Gaussian bundle{leaf.mean + random.in_cube(0.5), random.covariance(0.01, 0.3), 5};
    const Vector3d x_max = densest_overlap(leaf, bundle);
    const auto cost = [&](const Vector3d& x) {
      return mahalanobis_squared(x, leaf) + mahalanobis_squared(x, bundle);
    };
    for (int k = 0; k < 10; ++k) EXPECT_GT(cost(x_max + 1e-3 * random.direction()), cost(x_max));
  }
}

/// Round leaf and bundle on the x axis: x_max lies at share s^2 / (s^2 + r^2) of the way.
struct RoundPair {
  double s = 0.1;  ///< [m] sigma of the leaf
  double r = 0.1;  ///< [m] sigma of the bundle
  Gaussian leaf{Vector3d(1, 2, 3), s* s* Matrix3d::Identity(), 9};

  Gaussian bundle(double distance) const {
    return {leaf.mean + Vector3d(distance, 0, 0), r * r * Matrix3d::Identity(), 9};
  }
  /// At what distance of the means the point of densest overlap has this squared Mahalanobis distance.
  double distance_for_overlap_at(double mahalanobis_squared) const {
    return std::sqrt(mahalanobis_squared) * s * (s * s + r * r) / (s * s);
  }
};

TEST(Equation5, IsZeroOnceTheOverlapLeavesTheLeaf) {
  const RoundPair pair;
  const double border = kChiSquared95;
  for (const auto rule : {ImpactRule::kEquation5Inverse, ImpactRule::kEquation5Printed}) {
    EXPECT_EQ(equation5(pair.leaf, pair.bundle(pair.distance_for_overlap_at(border * (1 + 1e-9))), rule), 0);
  }
  const Gaussian inside = pair.bundle(pair.distance_for_overlap_at(border * (1 - 1e-9)));
  // A round leaf's longest half axis is every half axis: the inverse form has just reached 0 as well.
  const double inverse = equation5(pair.leaf, inside, ImpactRule::kEquation5Inverse);
  EXPECT_GT(inverse, 0);
  EXPECT_LT(inverse, 1e-8);
  // The printed form would be sqrt(7.815) / 2 = 1.40 there.
  EXPECT_EQ(equation5(pair.leaf, inside, ImpactRule::kEquation5Printed), 1);
}

TEST(Equation5, IsOneWhileTheMeanLiesInTheBundle) {
  const RoundPair pair;
  const double border = std::sqrt(kChiSquared95) * pair.r;
  for (const auto rule : {ImpactRule::kEquation5Inverse, ImpactRule::kEquation5Printed}) {
    EXPECT_EQ(equation5(pair.leaf, pair.bundle(border * (1 - 1e-9)), rule), 1);
    EXPECT_LT(equation5(pair.leaf, pair.bundle(border * (1 + 1e-9)), rule), 0.9);
  }
}

TEST(Equation5, ThirdCaseFollowsItsFormula) {
  RoundPair pair;
  pair.leaf.covariance = Vector3d(0.01, 0.0004, 0.0025).asDiagonal();
  // Along x: x_max at 0.01 / (0.01 + 0.0025) = 0.8 of 0.2 m.
  Gaussian bundle = pair.bundle(0.2);
  bundle.covariance = 0.0025 * Matrix3d::Identity();
  const double distance = 0.16;
  EXPECT_NEAR(equation5(pair.leaf, bundle, ImpactRule::kEquation5Inverse),
              1 - distance / (std::sqrt(kChiSquared95) * 0.1), 1e-12);
  EXPECT_NEAR(equation5(pair.leaf, bundle, ImpactRule::kEquation5Printed), distance / (2 * 0.1), 1e-12);
}

/// Away from the mean the inverse form falls from nearly 1 to 0 and the printed one rises to at most 1.
TEST(Equation5, ThirdCaseIsMonotone) {
  RoundPair pair;
  pair.r = 100;  // so wide that the overlap is still at the mean when the second case ends
  const double first = std::sqrt(kChiSquared95) * pair.r * (1 + 1e-9);
  const double last = pair.distance_for_overlap_at(kChiSquared95 * (1 - 1e-9));
  EXPECT_NEAR(equation5(pair.leaf, pair.bundle(first), ImpactRule::kEquation5Inverse), 1, 2e-3);
  double inverse_before = 1, printed_before = 0;
  for (int i = 0; i <= 1000; ++i) {
    const Gaussian bundle = pair.bundle(first + (last - first) * i / 1000);
    const double inverse = equation5(pair.leaf, bundle, ImpactRule::kEquation5Inverse);
    const double printed = equation5(pair.leaf, bundle, ImpactRule::kEquation5Printed);
    EXPECT_LT(inverse, inverse_before);
    EXPECT_GE(printed, printed_before);
    EXPECT_LE(printed, 1);
    inverse_before = inverse;
    printed_before = printed;
  }
  EXPECT_NEAR(inverse_before, 0, 1e-8);
  EXPECT_EQ(printed_before, 1);
}

TEST(Equation5, StaysBetweenZeroAndOne) {
  Random random(5);
  int third_case = 0;
  for (int i = 0; i < 20000; ++i) {
    const Gaussian leaf{random.in_cube(1), random.covariance(0.005, 0.15), 5};
    const Gaussian bundle{leaf.mean + random.in_cube(0.4), random.covariance(0.005, 0.15), 5};
    const double inverse = equation5(leaf, bundle, ImpactRule::kEquation5Inverse);
    const double printed = equation5(leaf, bundle, ImpactRule::kEquation5Printed);
    ASSERT_TRUE(inverse >= 0 && inverse <= 1) << inverse;
    ASSERT_TRUE(printed >= 0 && printed <= 1) << printed;
    third_case += inverse > 0 && inverse < 1;
  }
  EXPECT_GT(third_case, 1000);
}

TEST(PaperImpact, IsEquation5WhereTheBundleResemblesTheLeafMost) {
  Random random(8);
  UpdateParameters parameters = UpdateParameters::paper();
  int seen[3] = {0, 0, 0};  // zero, between, one
  for (int i = 0; i < 5000; ++i) {
    Encounter e = random_encounter(random);
    e.leaf.covariance = random.covariance(0.02, 0.15);
    e.leaf.mean = e.ray.origin + 0.5 * (e.ray.end - e.ray.origin) + random.in_cube(0.3);
    const auto t = static_cast<double>(std::min(1.0L, TravellingDivergence(e).minimum()));
    for (const auto rule : {ImpactRule::kEquation5Inverse, ImpactRule::kEquation5Printed}) {
      parameters.impact = rule;
      const double expected = equation5(e.leaf, travelling(e, t), rule);
      JudgedLeaf leaf(e.leaf, 0.4, 0, parameters);
      EXPECT_NEAR(leaf.impact(e.ray, e.bundle.covariance, 1), expected, 1e-6);
      EXPECT_EQ(leaf.impact(e.ray, e.bundle.covariance, t * (1 - 1e-6)), 0);
      ++seen[expected == 0 ? 0 : expected < 1 ? 1 : 2];
    }
  }
  EXPECT_GT(std::min({seen[0], seen[1], seen[2]}), 100);
}

const Vector3d kVoxelCenter(10, -20, 3);

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
    const Gaussian leaf{kVoxelCenter, random.covariance(0.01, 0.15), random.uniform(1, 100)};
    const Gaussian bundle{kVoxelCenter + random.in_cube(0.2), random.covariance(0.005, 0.15), 5};
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
    for (const Vector3d& p : kept) mean += (p - kVoxelCenter) / k;
    Matrix3d S = Matrix3d::Zero();
    for (const Vector3d& p : kept) S += (p - kVoxelCenter - mean) * (p - kVoxelCenter - mean).transpose() / k;
    S *= 7 / (2 * 7.814727903251179);  // so that all seven points give the leaf's own covariance
    EXPECT_LE((found->mean - kVoxelCenter - mean).norm(), 1e-13);
    EXPECT_LE((found->covariance - S).norm(), 1e-12 * leaf.covariance.trace());
    EXPECT_NEAR(found->count, leaf.count * k / 7, 1e-12 * leaf.count);
  }
  EXPECT_GT(refitted, 2000);
  EXPECT_GT(unchanged, 2000);
  EXPECT_GT(none, 20);
}

TEST(SigmaPointDifference, NothingInsideChangesNothing) {
  const Gaussian leaf{kVoxelCenter, Random(7).covariance({0.1, 0.05, 0.02}), 33};
  const auto found =
      sigma_point_difference(leaf, {kVoxelCenter + Vector3d(1, 0, 0), 1e-4 * Matrix3d::Identity(), 5});
  ASSERT_TRUE(found);
  EXPECT_EQ(found->mean, leaf.mean);
  EXPECT_EQ(found->covariance, leaf.covariance);
  EXPECT_EQ(found->count, leaf.count);
}

TEST(SigmaPointDifference, AllInsideLeavesNothing) {
  const Gaussian leaf{kVoxelCenter, Random(8).covariance({0.1, 0.05, 0.02}), 33};
  EXPECT_FALSE(sigma_point_difference(leaf, {kVoxelCenter, 0.0101 * Matrix3d::Identity(), 5}));
  EXPECT_TRUE(sigma_point_difference(leaf, {kVoxelCenter, 0.0099 * Matrix3d::Identity(), 5}));
}

}  // namespace
}  // namespace evermap
