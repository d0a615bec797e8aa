// SPDX-FileCopyrightText: 2026 the evermap authors
// SPDX-License-Identifier: BSD-3-Clause
#include <gtest/gtest.h>

#include "support/random_geometry.hpp"
#include <evermap/localization/detail/perturbation.hpp>

namespace evermap {
namespace {

TEST(Perturbation, DifferenceIsItsInverse) {
  test::Random random(1);
  for (int i = 0; i < 1000; ++i) {
    const Pose from{random.rotation(), random.in_cube(1e6)};
    Twist twist;
    twist << random.in_cube(5), random.uniform(0, 3) * random.direction();
    EXPECT_LT((difference(from, perturb(from, twist)) - twist).norm(), 1e-8);
  }
}

TEST(Perturbation, TurnsAboutTheSensorInTheMapsAxes) {
  const Pose from{Eigen::Matrix3d::Identity(), {100, 200, 300}};
  Twist quarter = Twist::Zero();
  quarter[5] = std::acos(0.0);
  const Pose to = perturb(from, quarter);
  EXPECT_EQ(to.translation, from.translation);
  EXPECT_LT((to * Eigen::Vector3d(1, 0, 0) - Eigen::Vector3d(100, 201, 300)).norm(), 1e-12);
}

}  // namespace
}  // namespace evermap
