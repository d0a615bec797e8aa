// SPDX-FileCopyrightText: 2026 the evermap authors
// SPDX-License-Identifier: BSD-3-Clause
#include <gtest/gtest.h>

#include <evermap/localization/detail/observability.hpp>

namespace evermap {
namespace {

constexpr double kLever = 10;

/// Walls that face each of these normals, seen all around.
Matrix6 walls(const std::vector<Eigen::Vector3d>& normals) {
  Matrix6 hessian = Matrix6::Zero();
  for (const Eigen::Vector3d& n : normals) {
    for (int x = -1; x <= 1; ++x) {
      for (int y = -1; y <= 1; ++y) {
        const Eigen::Vector3d r(kLever * x, kLever * y, kLever * ((x + 2 * y) % 3));
        const Twist J = jacobian(n, r);
        hessian += J * J.transpose();
      }
    }
  }
  return hessian;
}

TEST(Observability, NamesTheDirectionThatNothingHolds) {
  using V = Eigen::Vector3d;
  const auto weakest = [&](const std::vector<V>& normals) { return observability(walls(normals), kLever); };
  EXPECT_GT(weakest({V::UnitX(), V::UnitY(), V::UnitZ()}).fraction, 0.6);
  EXPECT_EQ(to_string(weakest({V::UnitY(), V::UnitZ()})), "translation along x");
  EXPECT_EQ(to_string(weakest({V::UnitX(), V::UnitZ()})), "translation along y");
  EXPECT_EQ(to_string(weakest({V::UnitX(), V::UnitY()})), "translation along z");
  EXPECT_NEAR(weakest({V::UnitY(), V::UnitZ()}).fraction, 0, 1e-9);
  const Observability oblique = weakest({V(1, -1, 0).normalized(), V::UnitZ()});
  EXPECT_FALSE(oblique.is_rotation);
  EXPECT_NEAR(std::abs(oblique.axis.dot(V(1, 1, 0).normalized())), 1, 1e-6);
}

TEST(Observability, OfNothingIsNone) { EXPECT_EQ(observability(Matrix6::Zero(), kLever).fraction, 0); }

}  // namespace
}  // namespace evermap
