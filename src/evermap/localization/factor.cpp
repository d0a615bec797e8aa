// SPDX-FileCopyrightText: 2026 the evermap authors
// SPDX-License-Identifier: BSD-3-Clause
#include <algorithm>
#include <cmath>

#include <Eigen/Geometry>
#include <Eigen/LU>

#include <evermap/localization/factor.hpp>

namespace evermap {

NormalEquations& NormalEquations::operator+=(const NormalEquations& other) {
  hessian += other.hessian;
  feigned += other.feigned;
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
  for (int i = 0; i < 2; ++i) {
    const Twist tilted = jacobian(tilts.col(i), from_sensor);
    equations.feigned += trust * kernel.weight(mahalanobis_squared) * stiffness * tilted * tilted.transpose();
  }
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

/// How much a normal may be off, by first-order perturbation of eigenvectors: leaf and bundle are estimates,
/// each from its points.
Eigen::Matrix<double, 3, 2> tilts(const Correspondence& match, double count, const Eigen::Vector3d& normal) {
  constexpr double kMost = 0.5;  // variance of a direction that is not known at all
  Eigen::Matrix<double, 3, 2> plane;
  plane.col(0) = normal.unitOrthogonal();
  plane.col(1) = normal.cross(plane.col(0));
  const Eigen::Matrix2d within = plane.transpose() * match.information * plane;
  const double angle = 0.5 * std::atan2(2 * within(0, 1), within(0, 0) - within(1, 1));
  plane = (plane * Eigen::Rotation2Dd(angle).toRotationMatrix()).eval();
  const auto along = [](const Eigen::Matrix3d& S, const Eigen::Vector3d& axis) { return axis.dot(S * axis); };
  const double across = 1 / along(match.information, normal);
  const double across_leaf = along(match.covariance_leaf, normal);
  for (int i = 0; i < 2; ++i) {
    const double both = 1 / along(match.information, plane.col(i));
    const double leaf = along(match.covariance_leaf, plane.col(i));
    const double noise = across_leaf * leaf / std::max(1.0, match.count_leaf) +
                         std::max(0.0, across - across_leaf) * std::max(0.0, both - leaf) / count;
    const double gap = std::max(both - across, 1e-9);
    plane.col(i) *= std::sqrt(std::min(kMost, noise / (gap * gap)));
  }
  return plane;
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
  return {match, normal, std::max(0.0, stiffest - next), tilts(match, count, normal),
          std::sqrt(count) * match.occupancy};
}

}  // namespace evermap
