// SPDX-FileCopyrightText: 2026 the evermap authors
// SPDX-License-Identifier: BSD-3-Clause
#include <cmath>
#include <support/random_geometry.hpp>
#include <vector>

#include <Eigen/Eigenvalues>
#include <Eigen/LU>
#include <gtest/gtest.h>

#include <evermap/update/detail/leaf_update.hpp>

namespace evermap {
namespace {

using Eigen::Matrix3d;
using Eigen::Vector3d;
using test::Random;

const Vector3d kCenter(10.1, -4.3, 2.5);  ///< [m] of the voxel under test
constexpr double kError = 0.002;          ///< [m] of the scans' alignment

Gaussian bundle_near_center(Random& random, double count) {
  return {kCenter + random.in_cube(0.08), random.covariance(0.01, 0.06), count};
}

/// How often a new leaf must be hit until it is occupied.
int hits_until_occupied(const UpdateParameters& parameters) {
  Random random(1);
  Leaf leaf;
  for (int hits = 1; hits < 50; ++hits) {
    confirm(leaf, bundle_near_center(random, 5), kCenter, kError, parameters);
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
    confirm(leaf, bundle, kCenter, kError, {});
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
    confirm(leaf, first, kCenter, kError, parameters);
    confirm(leaf, second, kCenter, kError, parameters);
    const Gaussian surface = leaf.gaussian(kCenter);
    const Gaussian expected = merge(first, second);
    EXPECT_LE((surface.mean - expected.mean).norm(), 3e-8);
    EXPECT_LE((surface.covariance - expected.covariance).norm(), 1e-6 * expected.covariance.trace());
    EXPECT_EQ(surface.count, 100);  // the cap limits the memory, not the weights of this union
  }
}

/// A surveyed patch, 2 cm thick, across a random direction.
struct Patch {
  explicit Patch(Random& random) : axes(random.rotation()) {
    leaf.set_gaussian(piece(0, 100), kCenter);
    leaf.log_odds = 3;
  }

  /// A piece of it, displaced along its normal [m].
  Gaussian piece(double displacement, double count) const {
    const Vector3d variance(4e-4, 0.01, 0.013);
    return {kCenter + displacement * axes.col(0), axes * variance.asDiagonal() * axes.transpose(), count};
  }
  double offset() const { return axes.col(0).dot(leaf.gaussian(kCenter).mean - kCenter); }

  Matrix3d axes;
  Leaf leaf;
};

/// However often poses are wrong to the same side, by less than the scan's own error tells.
TEST(Confirm, LeavesAKnownPlaneWhereItIsSeen) {
  Random random(8);
  for (int i = 0; i < 50; ++i) {
    Patch patch(random);
    for (int hit = 0; hit < 1000; ++hit)
      confirm(patch.leaf, patch.piece(0.005, 30), kCenter, kError, UpdateParameters{});
    EXPECT_NEAR(patch.offset(), 0, 1e-5);
    const Matrix3d S = patch.leaf.covariance_matrix();
    EXPECT_NEAR(patch.axes.col(0).dot(S * patch.axes.col(0)), 4e-4, 4e-6);
  }
}

TEST(Confirm, MovesAKnownPlaneThatIsSeenElsewhere) {
  Random random(9);
  for (int i = 0; i < 50; ++i) {
    Patch patch(random);
    for (int hit = 0; hit < 50; ++hit)
      confirm(patch.leaf, patch.piece(0.05, 30), kCenter, kError, UpdateParameters{});
    EXPECT_NEAR(patch.offset(), 0.05, 0.02);
  }
}

/// Within its plane a known leaf still learns how far it reaches.
TEST(Confirm, WidensAKnownPlaneWithinItself) {
  Random random(10);
  Patch patch(random);
  Gaussian beside = patch.piece(0, 100);
  beside.mean += 0.1 * patch.axes.col(1);
  confirm(patch.leaf, beside, kCenter, kError, UpdateParameters{});
  const Gaussian surface = patch.leaf.gaussian(kCenter);
  EXPECT_NEAR(patch.axes.col(1).dot(surface.mean - kCenter), 0.05, 1e-6);
  EXPECT_NEAR(patch.axes.col(1).dot(surface.covariance * patch.axes.col(1)), 0.01 + 0.0025, 1e-6);
}

std::vector<float> log_odds_of_hits(const UpdateParameters& parameters, int hits) {
  Random random(4);
  Leaf leaf;
  std::vector<float> log_odds;
  for (int i = 0; i < hits; ++i) {
    confirm(leaf, bundle_near_center(random, 5), kCenter, kError, parameters);
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
  confirm(once, bundle_near_center(random, 5), kCenter, kError, parameters);
  Leaf twice = once;
  confirm(twice, bundle_near_center(random, 5), kCenter, kError, parameters);
  EXPECT_FALSE(twice.occupied());
  Leaf untouched = once;
  EXPECT_TRUE(contradict(untouched, 0, parameters));
  EXPECT_FALSE(contradict(once, 0.1, parameters));
  EXPECT_TRUE(contradict(twice, 1, parameters));  // still above the first hit
  EXPECT_FALSE(contradict(twice, 1, parameters));
}

}  // namespace
}  // namespace evermap
