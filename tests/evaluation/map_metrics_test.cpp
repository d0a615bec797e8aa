// SPDX-FileCopyrightText: 2026 the evermap authors
// SPDX-License-Identifier: BSD-3-Clause
#include <cmath>
#include <limits>
#include <random>

#include <gtest/gtest.h>
#include <rapidcheck/gtest.h>

#include <evermap/evaluation/map_metrics.hpp>

namespace evermap {
namespace {

Points random_points(std::mt19937& generator, std::size_t count) {
  std::uniform_real_distribution<double> coordinate(-3, 3);
  Points points(count);
  for (auto& p : points) p = {coordinate(generator), coordinate(generator), coordinate(generator)};
  return points;
}

/// The definition, without a tree.
std::vector<double> nearest_by_brute_force(const Points& from, const Points& to) {
  std::vector<double> distances;
  for (const auto& p : from) {
    double nearest = std::numeric_limits<double>::infinity();
    for (const auto& q : to) nearest = std::min(nearest, (p - q).norm());
    distances.push_back(nearest);
  }
  return distances;
}

RC_GTEST_PROP(MapMetrics, AgreeWithBruteForce, (unsigned seed)) {
  std::mt19937 generator(seed);
  std::uniform_int_distribution<std::size_t> size(1, 300);
  const Points truth = random_points(generator, size(generator));
  const Points map = random_points(generator, size(generator));
  const auto truth_to_map = nearest_by_brute_force(truth, map);
  const auto map_to_truth = nearest_by_brute_force(map, truth);
  const SurfaceComparison comparison = compare_surfaces(truth, map);

  RC_ASSERT(comparison.truth_to_map.size() == truth.size());
  double sum = 0;
  double within = 0;
  for (std::size_t i = 0; i < truth.size(); ++i) {
    RC_ASSERT(std::abs(comparison.truth_to_map[i] - truth_to_map[i]) < 1e-12);
    sum += truth_to_map[i];
    within += truth_to_map[i] <= 0.5 ? 1 : 0;
  }
  const auto n = static_cast<double>(truth.size());
  RC_ASSERT(std::abs(comparison.mean_truth_to_map() - sum / n) < 1e-12);
  RC_ASSERT(std::abs(comparison.coverage(0.5) - within / n) < 1e-12);

  double back_sum = 0;
  double back_within = 0;
  for (const double d : map_to_truth) {
    back_sum += d;
    back_within += d <= 0.7 ? 1 : 0;
  }
  const auto m = static_cast<double>(map.size());
  RC_ASSERT(std::abs(comparison.mean_map_to_truth() - back_sum / m) < 1e-12);
  RC_ASSERT(std::abs(comparison.accuracy(0.7) - back_within / m) < 1e-12);
  RC_ASSERT(comparison.average_hausdorff_distance() ==
            std::max(comparison.mean_truth_to_map(), comparison.mean_map_to_truth()));
}

TEST(MapMetrics, TellMissingSurfaceFromGhosts) {
  const Points truth{{0, 0, 0}, {1, 0, 0}, {2, 0, 0}, {10, 0, 0}};
  const Points map{{0, 0, 0.05}, {1, 0, 0}, {2, 0, 0}, {2, 3, 0}, {2, 0, 4}};
  const SurfaceComparison comparison = compare_surfaces(truth, map);
  EXPECT_DOUBLE_EQ(comparison.coverage(0.1), 0.75);
  EXPECT_DOUBLE_EQ(comparison.coverage(0.01), 0.5);
  EXPECT_DOUBLE_EQ(comparison.accuracy(0.1), 0.6);
  EXPECT_NEAR(comparison.mean_truth_to_map(), (0.05 + 8) / 4, 1e-12);
  EXPECT_NEAR(comparison.mean_map_to_truth(), (0.05 + 3 + 4) / 5, 1e-12);
  EXPECT_NEAR(comparison.average_hausdorff_distance(), 8.05 / 4, 1e-12);
}

TEST(MapMetrics, ToleranceIsInclusive) {
  EXPECT_EQ(compare_surfaces({{0, 0, 0}}, {{0.5, 0, 0}}).coverage(0.5), 1);
}

TEST(MapMetrics, AnEmptyMapCoversNothingAndHasNoAccuracy) {
  const SurfaceComparison comparison = compare_surfaces({{0, 0, 0}}, {});
  EXPECT_EQ(comparison.coverage(1e9), 0);
  EXPECT_TRUE(std::isnan(comparison.accuracy(1)));
  EXPECT_TRUE(std::isinf(comparison.mean_truth_to_map()));
  EXPECT_TRUE(std::isnan(comparison.mean_map_to_truth()));
  EXPECT_TRUE(std::isinf(comparison.average_hausdorff_distance()));
  EXPECT_TRUE(std::isinf(compare_surfaces({}, {{0, 0, 0}}).average_hausdorff_distance()));
  EXPECT_TRUE(std::isnan(compare_surfaces({}, {}).average_hausdorff_distance()));
}

TEST(MapMetrics, LargeSetsAreComparedPointByPoint) {
  std::mt19937 generator(1);
  const Points truth = random_points(generator, 3000);
  const Points map = random_points(generator, 2000);
  const auto nearest = nearest_by_brute_force(truth, map);
  const auto distances = nearest_distances(truth, map);
  ASSERT_EQ(distances.size(), nearest.size());
  for (std::size_t i = 0; i < nearest.size(); ++i) ASSERT_NEAR(distances[i], nearest[i], 1e-12);
  EXPECT_EQ(compare_surfaces(truth, map).truth_to_map, distances) << "each time the same bits";
}

// The definitions by counting: of n static and n removed points, how many a map treats as it should.
RC_GTEST_PROP(MapMetrics, AccuraciesOfCountedPoints, (unsigned seed)) {
  std::mt19937 generator(seed);
  const Points unchanged = random_points(generator, 50);
  const Points removed = random_points(generator, 50);
  const auto claim = [](const Eigen::Vector3d& p) { return p.x() + p.y() > 0; };
  int kept = 0;
  int erased = 0;
  for (const auto& p : unchanged) kept += claim(p) ? 1 : 0;
  for (const auto& p : removed) erased += claim(p) ? 0 : 1;
  const double sa = fraction_true(unchanged, claim);
  const double da = 1 - fraction_true(removed, claim);
  RC_ASSERT(std::abs(sa - kept / 50.0) < 1e-12);
  RC_ASSERT(std::abs(da - erased / 50.0) < 1e-12);
  RC_ASSERT(std::abs(std::pow(associated_accuracy(sa, da), 2) * 2500 - kept * erased) < 1e-9);
  if (kept > 0 && erased > 0) {
    const double mean_of_inverses = (50.0 / kept + 50.0 / erased) / 2;
    RC_ASSERT(std::abs(1 / harmonic_accuracy(sa, da) - mean_of_inverses) < 1e-9);
  }
}

TEST(MapMetrics, NoMapWinsByKeepingOrErasingEverything) {
  EXPECT_EQ(associated_accuracy(1, 0), 0);
  EXPECT_EQ(harmonic_accuracy(1, 0), 0);
  EXPECT_EQ(harmonic_accuracy(0, 0), 0);
  EXPECT_TRUE(std::isnan(harmonic_accuracy(std::nan(""), 1)));
  EXPECT_DOUBLE_EQ(associated_accuracy(0.9, 0.4), 0.6);
  EXPECT_DOUBLE_EQ(harmonic_accuracy(0.9, 0.6), 0.72);
}

TEST(MapMetrics, FractionTrueCountsThePredicate) {
  const Points points{{0, 0, 0}, {1, 0, 0}, {2, 0, 0}, {3, 0, 0}};
  EXPECT_DOUBLE_EQ(fraction_true(points, [](const auto& p) { return p.x() > 0.5; }), 0.75);
  EXPECT_TRUE(std::isnan(fraction_true({}, [](const auto&) { return true; })));
}

}  // namespace
}  // namespace evermap
