// SPDX-FileCopyrightText: 2026 the evermap authors
// SPDX-License-Identifier: BSD-3-Clause
#include <random>

#include <gtest/gtest.h>

#include <evermap/simulation/triangle.hpp>

namespace evermap {
namespace {

TEST(Triangle2, CoversEveryPointOfATessellatedSquareExactlyOnce) {
  const Eigen::Vector2d a(0, 0), b(1, 0), c(1, 1), d(0, 1), middle(0.3, 0.6);
  const std::array<Triangle2, 4> fan{Triangle2{a, b, middle}, Triangle2{b, c, middle},
                                     Triangle2{c, d, middle}, Triangle2{middle, d, a}};
  for (int x = 1; x < 20; ++x) {
    for (int y = 1; y < 20; ++y) {
      int covers = 0;
      // Twentieths fall on the fan's corners and edges again and again.
      for (const auto& triangle : fan) covers += triangle.covers({x / 20.0, y / 20.0}) ? 1 : 0;
      EXPECT_EQ(covers, 1) << x << " " << y;
    }
  }
  for (const auto& triangle : fan) {
    EXPECT_FALSE(triangle.covers({1.1, 0.5}));
    EXPECT_FALSE(triangle.covers({0.5, -0.1}));
  }
}

TEST(Triangle3, ClosestPointIsNearestOfAllSampledPoints) {
  std::mt19937 generator(7);
  std::uniform_real_distribution<double> coordinate(-1, 1);
  const auto random_point = [&] {
    return Eigen::Vector3d(coordinate(generator), coordinate(generator), coordinate(generator));
  };
  for (int run = 0; run < 200; ++run) {
    const Triangle3 triangle{random_point(), random_point(), random_point()};
    const Eigen::Vector3d p = 2 * random_point();
    const double distance = (triangle.closest_point(p) - p).norm();
    double sampled = 1e9;
    constexpr int kSteps = 100;
    for (int i = 0; i <= kSteps; ++i) {
      for (int j = 0; j + i <= kSteps; ++j) {
        const Eigen::Vector3d q =
            triangle.a + (triangle.b - triangle.a) * i / kSteps + (triangle.c - triangle.a) * j / kSteps;
        sampled = std::min(sampled, (q - p).norm());
      }
    }
    EXPECT_LE(distance, sampled + 1e-12);
    EXPECT_GT(distance, sampled - 0.05);  // a step is at most 0.035 m
  }
}

}  // namespace
}  // namespace evermap
