// SPDX-FileCopyrightText: 2026 the evermap authors
// SPDX-License-Identifier: BSD-3-Clause
#include <cmath>

#include <Eigen/Eigenvalues>
#include <Eigen/LU>
#include <Eigen/QR>
#include <gtest/gtest.h>

#include "support/random_geometry.hpp"
#include <evermap/localization/detail/factor.hpp>
#include <evermap/localization/detail/perturbation.hpp>
#include <evermap/localization/detail/solver.hpp>

namespace evermap {
namespace {

TEST(Factor, JacobianIsTheDerivativeOfTheResidual) {
  test::Random random(2);
  for (int i = 0; i < 200; ++i) {
    const Pose T_map_sensor{random.rotation(), random.in_cube(100)};
    const Eigen::Vector3d p_sensor = random.in_cube(50);
    const Eigen::Vector3d leaf = random.in_cube(100);
    const Eigen::Vector3d normal = random.direction();
    const Twist J = jacobian(normal, T_map_sensor * p_sensor - T_map_sensor.translation);
    constexpr double kStep = 1e-5;
    for (int k = 0; k < 6; ++k) {
      const Twist step = kStep * Twist::Unit(k);
      const Eigen::Vector3d ahead = leaf - perturb(T_map_sensor, step) * p_sensor;
      const Eigen::Vector3d behind = leaf - perturb(T_map_sensor, -step) * p_sensor;
      EXPECT_NEAR(normal.dot(ahead - behind) / (2 * kStep), J[k], 1e-7);
    }
  }
}

TEST(Factor, GradientIsTheDerivativeOfHalfTheSum) {
  test::Random random(3);
  for (int i = 0; i < 200; ++i) {
    const Pose T_map_sensor{random.rotation(), random.in_cube(10)};
    const Eigen::Vector3d p_sensor = random.in_cube(20);
    const Eigen::Vector3d leaf = T_map_sensor * p_sensor + random.in_cube(0.3);
    const Eigen::Vector3d normal = random.direction();
    const Factor factor{{leaf, random.covariance(1, 30), normal, 1, 1}, 20, 1.7};
    const RobustKernel wide{1e6};
    const auto half_sum = [&](const Twist& step) {
      const Eigen::Vector3d e = leaf - perturb(T_map_sensor, step) * p_sensor;
      return 0.5 * 1.7 * 20 * std::pow(normal.dot(e), 2);
    };
    NormalEquations equations;
    factor.add_to(equations, T_map_sensor * p_sensor, T_map_sensor.rotation * p_sensor, wide);
    for (int k = 0; k < 6; ++k) {
      const Twist step = 1e-6 * Twist::Unit(k);
      const double slope = (half_sum(step) - half_sum(-step)) / 2e-6;
      EXPECT_NEAR(equations.gradient[k], slope, 1e-5 * (1 + equations.gradient.norm()));
    }
  }
}

TEST(Factor, CountsTheStiffestAxisAsFarAsItIsStifferThanTheNext) {
  test::Random random(9);
  for (int i = 0; i < 2000; ++i) {
    const Eigen::Matrix3d M = random.covariance(0.01, 1).inverse();
    const Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d> eigen(M);
    const double greatest = eigen.eigenvalues()[2];
    const double gap = greatest - eigen.eigenvalues()[1];
    const Eigen::Vector3d axis = eigen.eigenvectors().col(2);
    const auto made = make_factor({Eigen::Vector3d::Zero(), M, stiffest_axis(M), 0, 0.5}, 9);
    if (!made) continue;  // a line
    const Factor& factor = *made;
    EXPECT_EQ(factor.trust, 1.5);
    const Eigen::Vector3d& normal = factor.match.normal;
    EXPECT_NEAR(normal.norm(), 1, 1e-12);
    // Where the next is nearly as stiff, the axis is known less well, and counts for less.
    const Eigen::Matrix3d counted = factor.stiffness * normal * normal.transpose();
    EXPECT_LT((counted - gap * axis * axis.transpose()).norm(), 0.04 * greatest);
    if (gap > 0.5 * greatest) {
      EXPECT_LT((counted - gap * axis * axis.transpose()).norm(), 1e-4 * greatest);
    }
  }
}

TEST(Factor, OfASphereSaysNothing) {
  const Eigen::Matrix3d M = 7 * Eigen::Matrix3d::Identity();
  const Factor factor = *make_factor({Eigen::Vector3d::Zero(), M, stiffest_axis(M), 0, 1}, 1);
  EXPECT_NEAR(factor.stiffness, 0, 1e-6);
}

// Standard deviations of a ring's points in a voxel of 0.4 m: along it, in range, in elevation.
TEST(Factor, OfALineTellsWhereTheBeamsAre) {
  test::Random random(10);
  const auto of_patch = [&](double length, double width) {
    const Eigen::Matrix3d R = random.rotation();
    const Eigen::Vector3d extent(length, width, 0.005);
    const Eigen::Matrix3d M = (R * extent.cwiseAbs2().asDiagonal() * R.transpose()).inverse();
    return make_factor({Eigen::Vector3d::Zero(), M, stiffest_axis(M), 0, 1}, 20).has_value();
  };
  for (int i = 0; i < 20; ++i) {
    EXPECT_FALSE(of_patch(0.11, 0.02));
    EXPECT_TRUE(of_patch(0.11, 0.06)) << "two rings";
    EXPECT_TRUE(of_patch(0.03, 0.02)) << "the corner of a small leaf";
    EXPECT_TRUE(of_patch(0.5, 0.3)) << "a wide leaf";
  }
}

TEST(Solver, SolvesWhatIsRegularAndStaysWhereNothingIsSaid) {
  const Directions all = Matrix6::Identity();
  NormalEquations equations;
  EXPECT_EQ(solve(equations, all, 1e-6), Twist::Zero());
  test::Random random(4);
  for (int i = 0; i < 6; ++i) {
    const Twist row = (Twist() << random.normal3(), random.normal3()).finished();
    equations.hessian += row * row.transpose();
  }
  const Twist step = (Twist() << random.normal3(), random.normal3()).finished();
  equations.gradient = -equations.hessian * step;
  EXPECT_LT((solve(equations, all, 0) - step).norm(), 1e-6 * step.norm());
  EXPECT_EQ(solve(equations, Directions(6, 0), 0), Twist::Zero());
  // Along some directions: the least there, and not a hair across.
  const Directions some = Directions(Matrix6(Matrix6::Random() + 3 * Matrix6::Identity()).leftCols(4));
  const Twist found = solve(equations, some, 0);
  EXPECT_LT((some.transpose() * (equations.hessian * found + equations.gradient)).norm(), 1e-6);
  EXPECT_LT((some * some.colPivHouseholderQr().solve(found) - found).norm(), 1e-9 * found.norm());
}

}  // namespace
}  // namespace evermap
