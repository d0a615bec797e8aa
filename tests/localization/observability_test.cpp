// SPDX-FileCopyrightText: 2026 the evermap authors
// SPDX-License-Identifier: BSD-3-Clause
#include <cmath>
#include <vector>

#include <gtest/gtest.h>

#include <evermap/localization/detail/observability.hpp>

namespace evermap {
namespace {

constexpr double kReach = 10;       // [m]
constexpr double kStiffness = 1e4;  // [1/m^2] of 1 cm

/// Walls that face each of these normals, seen all around.
Matrix6 walls(const std::vector<Eigen::Vector3d>& normals) {
  Matrix6 information = Matrix6::Zero();
  for (const Eigen::Vector3d& n : normals) {
    for (int x = -1; x <= 1; ++x) {
      for (int y = -1; y <= 1; ++y) {
        const Twist J = jacobian(n, {kReach * x, kReach * y, kReach * ((x + 2 * y) % 3)});
        information += kStiffness * J * J.transpose();
      }
    }
  }
  return information;
}

Observability of(const std::vector<Eigen::Vector3d>& normals) { return observability(walls(normals), 1, {}); }

TEST(Observability, NamesTheDirectionThatNothingHolds) {
  using V = Eigen::Vector3d;
  EXPECT_TRUE(of({V::UnitX(), V::UnitY(), V::UnitZ()}).is_complete());
  EXPECT_EQ(to_string(of({V::UnitY(), V::UnitZ()})), "translation along x");
  EXPECT_EQ(to_string(of({V::UnitX(), V::UnitZ()})), "translation along y");
  EXPECT_EQ(to_string(of({V::UnitX(), V::UnitY()})), "translation along z");
  EXPECT_EQ(of({V::UnitY(), V::UnitZ()}).unobservable, 1);
  const Observability oblique = of({V(1, -1, 0).normalized(), V::UnitZ()});
  EXPECT_FALSE(oblique.is_rotation);
  EXPECT_NEAR(std::abs(oblique.axis.dot(V(1, 1, 0).normalized())), 1, 1e-6);
}

TEST(Observability, IsTheAccuracyThatResults) {
  using V = Eigen::Vector3d;
  const Observability all = of({V::UnitX(), V::UnitY(), V::UnitZ()});
  // Nine patches of 1 cm hold each axis to 3.3 mm, when turns are known.
  EXPECT_GT(std::sqrt(all.covariance(0, 0)), 0.0033);
  EXPECT_LT(std::sqrt(all.covariance(0, 0)), 0.006);
  const Observability noisier = observability(walls({V::UnitX(), V::UnitY(), V::UnitZ()}), 4, {});
  EXPECT_NEAR(noisier.covariance(0, 0), 4 * all.covariance(0, 0), 1e-9);
}

TEST(Observability, LittleInformationIsNone) {
  using V = Eigen::Vector3d;
  const Matrix6 information = 1e-4 * walls({V::UnitX()}) + walls({V::UnitY(), V::UnitZ()});
  EXPECT_EQ(to_string(observability(information, 1, {})), "translation along x");
  EXPECT_FALSE(observability(information, 1, {}).is_complete());
}

TEST(Observability, OfNothingIsNone) { EXPECT_EQ(observability(Matrix6::Zero(), 1, {}).unobservable, 6); }

}  // namespace
}  // namespace evermap
