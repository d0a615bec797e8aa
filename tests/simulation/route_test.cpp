// SPDX-FileCopyrightText: 2026 the evermap authors
// SPDX-License-Identifier: BSD-3-Clause
#include <cmath>
#include <numbers>
#include <random>
#include <stdexcept>

#include <gtest/gtest.h>

#include <evermap/simulation/route.hpp>

namespace evermap {
namespace {

using Waypoints = std::vector<Route::Waypoint>;

Eigen::Vector2d xy_at(const Route& route, double time) { return route.at(time).value().xy; }

TEST(Route, IsStraightBetweenTwoWaypoints) {
  const Route route({{{1, 2}, 2}, {{1, 12}, 2}}, 5, 0, Route::End::kStay);
  EXPECT_NEAR(route.length(), 10, 1e-12);
  EXPECT_NEAR(route.duration(), 5, 1e-12);
  EXPECT_TRUE(xy_at(route, 1.5).isApprox(Eigen::Vector2d(1, 5)));
  EXPECT_NEAR(route.at(1.5)->yaw, std::numbers::pi / 2, 1e-12);
}

TEST(Route, StaysBeforeItsStartAndAfterItsEnd) {
  const Route route({{{0, 0}, 2}, {{10, 0}, 2}}, 0, 3, Route::End::kStay);
  EXPECT_TRUE(xy_at(route, 2.9).isApprox(Eigen::Vector2d(0, 0)));
  EXPECT_TRUE(xy_at(route, 4).isApprox(Eigen::Vector2d(2, 0)));
  EXPECT_TRUE(xy_at(route, 99).isApprox(Eigen::Vector2d(10, 0)));
}

TEST(Route, VanishesOutsideItsTime) {
  const Route route({{{0, 0}, 2}, {{10, 0}, 2, 1}}, 0, 3, Route::End::kVanish);
  EXPECT_FALSE(route.at(2.99));
  EXPECT_TRUE(route.at(3));
  EXPECT_TRUE(route.at(8.9)) << "waits at the end";
  EXPECT_FALSE(route.at(9));
}

TEST(Route, RoundsACornerToAnArcOfItsRadius) {
  const Route route({{{0, 0}, 1}, {{10, 0}, 1}, {{10, 10}, 1}}, 4, 0, Route::End::kStay);
  EXPECT_NEAR(route.length(), 6 + 2 * std::numbers::pi + 6, 1e-9);
  for (double s = 6.1; s < 12.2; s += 0.5) {
    const Place place = route.at(s).value();
    const Eigen::Vector2d from_center = place.xy - Eigen::Vector2d(6, 4);
    EXPECT_NEAR(from_center.norm(), 4, 1e-9);
    EXPECT_NEAR(from_center.dot(Eigen::Vector2d(std::cos(place.yaw), std::sin(place.yaw))), 0, 1e-9);
  }
  EXPECT_NEAR(xy_at(route, route.length() - 1).y(), 9, 1e-9);
}

TEST(Route, ACornerTakesNoMoreThanItsShareOfALine) {
  const Route route({{{0, 0}, 1}, {{4, 0}, 1}, {{4, 4}, 1}, {{0, 4}, 1}}, 100, 0, Route::End::kLoop);
  EXPECT_NEAR(route.length(), 4 * std::numbers::pi, 1e-9) << "a circle";
}

TEST(Route, TurnsBackOnTheSpot) {
  const Route route({{{0, 0}, 1}, {{5, 0}, 1}}, 3, 0, Route::End::kLoop);
  EXPECT_TRUE(xy_at(route, 5).isApprox(Eigen::Vector2d(5, 0)));
  EXPECT_TRUE(xy_at(route, 7).isApprox(Eigen::Vector2d(3, 0)));
  EXPECT_NEAR(std::abs(route.at(7)->yaw), std::numbers::pi, 1e-9);
}

TEST(Route, AcceleratesEvenly) {
  const Route route({{{0, 0}, 2}, {{16, 0}, 6}}, 0, 0, Route::End::kStay);
  EXPECT_NEAR(route.duration(), 4, 1e-12);
  EXPECT_NEAR(xy_at(route, 2).x(), 6, 1e-12);
}

TEST(Route, WaitsAtAWaypoint) {
  const Route route({{{0, 0}, 2, 1}, {{10, 0}, 2, 3}, {{20, 0}, 2}}, 0, 0, Route::End::kStay);
  EXPECT_NEAR(xy_at(route, 0.9).x(), 0, 1e-12);
  EXPECT_NEAR(xy_at(route, 6.1).x(), 10, 1e-12);
  EXPECT_NEAR(xy_at(route, 8.9).x(), 10, 1e-12);
  EXPECT_NEAR(xy_at(route, 9.5).x(), 11, 1e-12);
  EXPECT_NEAR(route.duration(), 14, 1e-12);
}

TEST(Route, NeverJumps) {
  std::mt19937 generator(3);
  std::uniform_real_distribution<double> place(-30, 30);
  std::uniform_real_distribution<double> speed(1, 8);
  for (int round = 0; round < 200; ++round) {
    Waypoints waypoints;
    for (int i = 0; i < 6; ++i) waypoints.push_back({{place(generator), place(generator)}, speed(generator)});
    const Route route(waypoints, 5, 0, round % 2 == 0 ? Route::End::kLoop : Route::End::kStay);
    constexpr double kStep = 0.02;
    for (double time = 0; time < 1.2 * route.duration(); time += kStep) {
      ASSERT_LT((xy_at(route, time + kStep) - xy_at(route, time)).norm(), 8 * kStep + 1e-9) << time;
    }
  }
}

TEST(Route, ALoopComesAround) {
  const Route route({{{0, 0}, 3}, {{20, 0}, 5}, {{20, 20}, 4}}, 3, 0, Route::End::kLoop);
  for (double time = 0; time < 10; time += 0.7) {
    EXPECT_LT((xy_at(route, time) - xy_at(route, time + 3 * route.duration())).norm(), 1e-9);
  }
}

TEST(Route, RefusesWhatCannotBe) {
  const auto make = [](const Waypoints& waypoints, double radius = 1, double start = 0) {
    Route(waypoints, radius, start, Route::End::kStay);
  };
  EXPECT_THROW(make({}), std::invalid_argument);
  EXPECT_THROW(make({{{0, 0}, 1}}), std::invalid_argument);
  EXPECT_THROW(make({{{0, 0}, 1}, {{0, 0}, 1}}), std::invalid_argument);
  EXPECT_THROW(make({{{0, 0}, 0}, {{1, 0}, 1}}), std::invalid_argument);
  EXPECT_THROW(make({{{0, 0}, 1, -1}, {{1, 0}, 1}}), std::invalid_argument);
  EXPECT_THROW(make({{{0, 0}, 1}, {{1, 0}, 1}}, -1), std::invalid_argument);
  EXPECT_THROW(make({{{0, 0}, 1}, {{1, 0}, 1}}, 1, -1), std::invalid_argument);
  EXPECT_NO_THROW(make({{{0, 0}, 1}, {{1, 0}, 1}}));
}

}  // namespace
}  // namespace evermap
