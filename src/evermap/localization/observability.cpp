// SPDX-FileCopyrightText: 2026 the evermap authors
// SPDX-License-Identifier: BSD-3-Clause
#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>

#include <Eigen/Eigenvalues>

#include <evermap/localization/detail/observability.hpp>

namespace evermap {
Observability observability(const Matrix6& information, double noise, const AccuracyLimits& limits) {
  Observability result;
  // In units of the limits all directions are alike, and an eigenvalue is 1 / variance.
  Twist units;
  units << Eigen::Vector3d::Constant(limits.translation), Eigen::Vector3d::Constant(limits.rotation);
  const Matrix6 scaled = units.asDiagonal() * information * units.asDiagonal();
  const Eigen::SelfAdjointEigenSolver<Matrix6> eigen(scaled);
  Matrix6 covariance = Matrix6::Zero();
  for (int i = 0; i < 6; ++i) {
    const Twist direction = eigen.eigenvectors().col(i);
    if (eigen.eigenvalues()[i] <= noise) continue;
    --result.unobservable;
    covariance += noise / eigen.eigenvalues()[i] * direction * direction.transpose();
  }
  result.covariance = units.asDiagonal() * covariance * units.asDiagonal();
  result.directions = units.asDiagonal() * eigen.eigenvectors();
  const Twist worst = eigen.eigenvectors().col(0);
  const bool is_rotation = worst.tail<3>().norm() > worst.head<3>().norm();
  result.is_rotation = is_rotation;
  result.axis = (is_rotation ? worst.tail<3>() : worst.head<3>()).normalized();
  result.worst = std::sqrt(noise / std::max(eigen.eigenvalues()[0], 1e-12));
  return result;
}

std::string to_string(const Observability& direction) {
  const std::string what = direction.is_rotation ? "rotation about " : "translation along ";
  constexpr double kCosineOf15Degrees = 0.966;
  Eigen::Index axis = 0;
  if (direction.axis.cwiseAbs().maxCoeff(&axis) > kCosineOf15Degrees) return what + "xyz"[axis];
  std::array<char, 64> vector{};
  std::snprintf(vector.data(), vector.size(), "(%.2f, %.2f, %.2f)", direction.axis.x(), direction.axis.y(),
                direction.axis.z());
  return what + vector.data();
}

}  // namespace evermap
