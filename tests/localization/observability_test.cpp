// SPDX-FileCopyrightText: 2026 the evermap authors
// SPDX-License-Identifier: BSD-3-Clause
#include <vector>

#include <Eigen/LU>
#include <gtest/gtest.h>

#include <evermap/localization/detail/factor.hpp>
#include <evermap/localization/detail/observability.hpp>
#include <evermap/localization/detail/registration.hpp>

namespace evermap {
namespace {

using V = Eigen::Vector3d;

/// Walls that face each of these normals, 10 m off, seen all around.
Matrix6 walls(const std::vector<V>& normals) {
  Matrix6 information = Matrix6::Zero();
  for (const V& n : normals) {
    for (int x = -1; x <= 1; ++x) {
      for (int y = -1; y <= 1; ++y) {
        const Twist J = jacobian(n, V(10 * x, 10 * y, 10 * ((x + 2 * y) % 3)));
        information += J * J.transpose();
      }
    }
  }
  return 1e6 * information;  // of 1 mm each
}

TEST(Observability, NamesTheDirectionThatNothingHolds) {
  const auto weakest = [](const std::vector<V>& normals) {
    return weakest_direction(learn(walls(normals), within(0.5, 0.05)).covariance);
  };
  EXPECT_LT(weakest({V::UnitX(), V::UnitY(), V::UnitZ()}).sigma, 0.001);
  EXPECT_EQ(to_string(weakest({V::UnitY(), V::UnitZ()})), "translation along x");
  EXPECT_EQ(to_string(weakest({V::UnitX(), V::UnitZ()})), "translation along y");
  EXPECT_EQ(to_string(weakest({V::UnitX(), V::UnitY()})), "translation along z");
  EXPECT_NEAR(weakest({V::UnitY(), V::UnitZ()}).sigma, 0.5, 1e-6);
  const WeakestDirection oblique = weakest({V(1, -1, 0).normalized(), V::UnitZ()});
  EXPECT_FALSE(oblique.is_rotation);
  EXPECT_NEAR(std::abs(oblique.axis.dot(V(1, 1, 0).normalized())), 1, 1e-6);
}

TEST(Knowledge, WhereSurfacesSayMoreTheyAreAsked) {
  const Matrix6 before = within(0.5, 0.05);
  EXPECT_EQ(learn(walls({V::UnitX(), V::UnitY(), V::UnitZ()}), before).directions.cols(), 6);
  const Knowledge in_corridor = learn(walls({V::UnitY(), V::UnitZ()}), before);
  ASSERT_EQ(in_corridor.directions.cols(), 5);
  EXPECT_LT(in_corridor.directions.row(0).norm(), 1e-6 * in_corridor.directions.norm());
  EXPECT_EQ(learn(Matrix6::Zero(), before).directions.cols(), 0);
  EXPECT_LT((learn(Matrix6::Zero(), before).covariance - before).norm(), 1e-9);
  EXPECT_EQ(learn(-Matrix6::Identity(), before).directions.cols(), 0) << "noise may make it negative";
}

TEST(Knowledge, JoinsWhatWasKnownWithWhatIsSeen) {
  const Matrix6 before = within(0.3, 0.02);
  const Matrix6 information = walls({V::UnitX(), V::UnitY(), V::UnitZ()}) / 1e6;
  const Matrix6 joined = (before.inverse() + information).inverse();
  EXPECT_LT((learn(information, before).covariance - joined).norm(), 1e-9 * joined.norm());
}

}  // namespace
}  // namespace evermap
