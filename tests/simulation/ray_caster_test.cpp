// SPDX-FileCopyrightText: 2026 the evermap authors
// SPDX-License-Identifier: BSD-3-Clause
#include <cmath>
#include <numbers>

#include <gtest/gtest.h>

#include <evermap/simulation/ray_caster.hpp>

namespace evermap {
namespace {

Scene box_at(double x) {
  Scene scene;
  Pose T_map_box;
  T_map_box.translation.x() = x;
  add_box(scene, 3, T_map_box, {1, 1, 1});
  return scene;
}

TEST(RayCaster, GivesRangeObjectAndIncidence) {
  const RayCaster rays(box_at(5));
  const double angle = 0.05;
  const auto hit = rays.first_hit({0, 0.1, 0}, {std::cos(angle), 0, std::sin(angle)});
  ASSERT_TRUE(hit);
  EXPECT_NEAR(hit->range, 4.5 / std::cos(angle), 1e-12);
  EXPECT_NEAR(hit->cosine, std::cos(angle), 1e-12);
  EXPECT_EQ(hit->object, 3);
}

TEST(RayCaster, LooksNoFartherThanItsLimit) {
  const RayCaster rays(box_at(5));
  EXPECT_TRUE(rays.first_hit({0, 0.1, 0}, {1, 0, 0}, 4.6));
  EXPECT_FALSE(rays.first_hit({0, 0.1, 0}, {1, 0, 0}, 4.4));
}

TEST(RayCaster, MeetsFacesFromBehindToo) {
  const auto hit = RayCaster(box_at(0)).first_hit({0, 0.1, 0.1}, {1, 0, 0});
  ASSERT_TRUE(hit);
  EXPECT_NEAR(hit->range, 0.5, 1e-12);
  EXPECT_NEAR(hit->cosine, 1, 1e-12);
}

}  // namespace
}  // namespace evermap
