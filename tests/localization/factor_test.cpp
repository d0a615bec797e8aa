// SPDX-FileCopyrightText: 2026 the evermap authors
// SPDX-License-Identifier: BSD-3-Clause
#include <cmath>

#include <Eigen/Eigenvalues>
#include <Eigen/LU>
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
    const Factor factor{{leaf, random.covariance(1, 30), 1, 1}, random.direction(), 20, 1.7};
    const RobustKernel wide{1e6};
    const auto half_sum = [&](const Twist& step) {
      const Eigen::Vector3d e = leaf - perturb(T_map_sensor, step) * p_sensor;
      return 0.5 * 1.7 * 20 * std::pow(factor.normal.dot(e), 2);
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
    const Factor factor = make_factor({Eigen::Vector3d::Zero(), M, 0, 0.5}, 9);
    EXPECT_EQ(factor.trust, 1.5);
    EXPECT_NEAR(factor.normal.norm(), 1, 1e-12);
    // Where the next is nearly as stiff, the axis is known less well, and counts for less.
    const Eigen::Matrix3d counted = factor.stiffness * factor.normal * factor.normal.transpose();
    EXPECT_LT((counted - gap * axis * axis.transpose()).norm(), 0.04 * greatest);
    if (gap > 0.5 * greatest) {
      EXPECT_LT((counted - gap * axis * axis.transpose()).norm(), 1e-4 * greatest);
    }
  }
}

TEST(Factor, OfASphereSaysNothing) {
  const Factor factor = make_factor({Eigen::Vector3d::Zero(), 7 * Eigen::Matrix3d::Identity(), 0, 1}, 1);
  EXPECT_NEAR(factor.stiffness, 0, 1e-6);
}

TEST(Solver, SolvesWhatIsRegularAndStaysWhereNothingIsSaid) {
  NormalEquations equations;
  EXPECT_EQ(solve(equations, 1e-6), Twist::Zero());
  test::Random random(4);
  for (int i = 0; i < 6; ++i) {
    const Twist row = (Twist() << random.normal3(), random.normal3()).finished();
    equations.hessian += row * row.transpose();
  }
  const Twist step = (Twist() << random.normal3(), random.normal3()).finished();
  equations.gradient = -equations.hessian * step;
  EXPECT_LT((solve(equations, 0) - step).norm(), 1e-6 * step.norm());
}

}  // namespace
}  // namespace evermap
