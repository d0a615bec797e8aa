// SPDX-FileCopyrightText: 2026 the evermap authors
// SPDX-License-Identifier: BSD-3-Clause
#include <algorithm>
#include <cmath>

#include <Eigen/LU>

#include <evermap/localization/detail/factor.hpp>

namespace evermap {

NormalEquations& NormalEquations::operator+=(const NormalEquations& other) {
  hessian += other.hessian;
  gradient += other.gradient;
  matched += other.matched;
  inliers += other.inliers;
  inlier_error += other.inlier_error;
  return *this;
}

Twist jacobian(const Eigen::Vector3d& normal, const Eigen::Vector3d& from_sensor) {
  return (Twist() << -normal, normal.cross(from_sensor)).finished();
}

void Factor::add_to(NormalEquations& equations, const Eigen::Vector3d& mean_map,
                    const Eigen::Vector3d& from_sensor, const RobustKernel& kernel) const {
  const Eigen::Vector3d residual = match.mean_leaf - mean_map;
  const double mahalanobis_squared = residual.dot(match.information * residual);
  const Twist row = jacobian(normal, from_sensor);
  const Twist weighted = trust * kernel.weight(mahalanobis_squared) * stiffness * row;
  equations.hessian += weighted * row.transpose();
  equations.gradient += normal.dot(residual) * weighted;
  ++equations.matched;
  if (mahalanobis_squared >= kChiSquared95) return;
  ++equations.inliers;
  equations.inlier_error += mahalanobis_squared;
}

namespace {

/// The square of a symmetric matrix: symmetric, too, so that half of the products are enough.
Eigen::Matrix3d square(const Eigen::Matrix3d& S) {
  const double xx = S(0, 0), xy = S(1, 0), xz = S(2, 0), yy = S(1, 1), yz = S(2, 1), zz = S(2, 2);
  Eigen::Matrix3d squared;
  squared(0, 0) = xx * xx + xy * xy + xz * xz;
  squared(1, 1) = xy * xy + yy * yy + yz * yz;
  squared(2, 2) = xz * xz + yz * yz + zz * zz;
  squared(0, 1) = squared(1, 0) = xy * (xx + yy) + xz * yz;
  squared(0, 2) = squared(2, 0) = xz * (xx + zz) + xy * yz;
  squared(1, 2) = squared(2, 1) = yz * (yy + zz) + xy * xz;
  return squared;
}

}  // namespace

Factor make_factor(const Correspondence& match, double count) {
  // Powers of M turn towards its stiffest axis. All eigenvectors would take several times as long.
  const Eigen::Matrix3d& M = match.information;
  const double trace = M.trace();
  Eigen::Matrix3d power = M / trace;  // so that the 24th lies between 1 and 3^-24
  for (int doubling = 0; doubling < 3; ++doubling) power = square(power);
  Eigen::Index column = 0;
  power.diagonal().maxCoeff(&column);
  Eigen::Vector3d normal = power * (power * power.col(column));
  normal.normalize();
  const double stiffest = normal.dot(M * normal);
  // Of the other two eigenvalues, the sum and the product are known.
  const double half_sum = (trace - stiffest) / 2;
  const double product = M.determinant() / stiffest;
  const double next = half_sum + std::sqrt(std::max(0.0, half_sum * half_sum - product));
  return {match, normal, std::max(0.0, stiffest - next), std::sqrt(count) * match.occupancy};
}

}  // namespace evermap
