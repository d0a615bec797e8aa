// SPDX-FileCopyrightText: 2026 the evermap authors
// SPDX-License-Identifier: BSD-3-Clause
#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>

#include <Eigen/Cholesky>
#include <Eigen/Eigenvalues>

#include <evermap/localization/detail/observability.hpp>

namespace evermap {

WeakestDirection weakest_direction(const Matrix6& covariance) {
  constexpr double kLever = 10;  // [m]
  const Twist units = (Twist() << 1, 1, 1, kLever, kLever, kLever).finished();
  const Matrix6 scaled = units.asDiagonal() * covariance * units.asDiagonal();
  const Eigen::SelfAdjointEigenSolver<Matrix6> eigen(scaled);
  const Twist worst = eigen.eigenvectors().col(5);
  const double sigma = std::sqrt(std::max(0.0, eigen.eigenvalues()[5]));
  const bool is_rotation = worst.tail<3>().norm() > worst.head<3>().norm();
  return {is_rotation ? sigma / kLever : sigma, is_rotation,
          (is_rotation ? worst.tail<3>() : worst.head<3>()).normalized()};
}

std::string to_string(const WeakestDirection& direction) {
  const std::string what = direction.is_rotation ? "rotation about " : "translation along ";
  constexpr double kCosineOf15Degrees = 0.966;
  Eigen::Index axis = 0;
  if (direction.axis.cwiseAbs().maxCoeff(&axis) > kCosineOf15Degrees) return what + "xyz"[axis];
  std::array<char, 64> vector{};
  std::snprintf(vector.data(), vector.size(), "(%.2f, %.2f, %.2f)", direction.axis.x(), direction.axis.y(),
                direction.axis.z());
  return what + vector.data();
}

Knowledge learn(const Matrix6& information, const Matrix6& covariance) {
  const Matrix6 root = covariance.llt().matrixL();  // in its columns as units, all is known alike before
  const Matrix6 gained = root.transpose() * information * root;
  const Eigen::SelfAdjointEigenSolver<Matrix6> eigen(gained);
  const auto surfaces_say_more = (eigen.eigenvalues().array() > 1).count();
  const Twist left = (1 + eigen.eigenvalues().array().max(0)).inverse();
  const Matrix6 units = root * eigen.eigenvectors();
  return {units * left.asDiagonal() * units.transpose(), units.rightCols(surfaces_say_more)};
}

}  // namespace evermap
