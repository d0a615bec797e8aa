// SPDX-FileCopyrightText: 2026 the evermap authors
// SPDX-License-Identifier: BSD-3-Clause
#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>

#include <Eigen/Eigenvalues>

#include <evermap/localization/detail/observability.hpp>

namespace evermap {

Observability observability(const Matrix6& hessian, double lever) {
  Twist units;
  units << 1, 1, 1, 1 / lever, 1 / lever, 1 / lever;
  const Matrix6 scaled = units.asDiagonal() * hessian * units.asDiagonal();
  const Eigen::SelfAdjointEigenSolver<Matrix6> eigen(scaled);
  const double mean = eigen.eigenvalues().mean();
  if (mean <= 0) return {};
  const Twist worst = eigen.eigenvectors().col(0);
  const bool is_rotation = worst.tail<3>().norm() > worst.head<3>().norm();
  return {std::max(0.0, eigen.eigenvalues()[0] / mean), is_rotation,
          (is_rotation ? worst.tail<3>() : worst.head<3>()).normalized()};
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
