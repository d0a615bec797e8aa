// SPDX-FileCopyrightText: 2026 the evermap authors
// SPDX-License-Identifier: BSD-3-Clause
#include <algorithm>
#include <cmath>

#include <Eigen/Eigenvalues>

#include <evermap/localization/factor.hpp>

namespace evermap {

NormalEquations& NormalEquations::operator+=(const NormalEquations& other) {
  hessian += other.hessian;
  gradient += other.gradient;
  matched += other.matched;
  inliers += other.inliers;
  inlier_error += other.inlier_error;
  return *this;
}

Eigen::Matrix<double, 3, 6> jacobian(const Eigen::Vector3d& from_sensor) {
  const Eigen::Vector3d& r = from_sensor;
  Eigen::Matrix<double, 3, 6> J;
  J << -1, 0, 0, 0, -r.z(), r.y(),  //
      0, -1, 0, r.z(), 0, -r.x(),   //
      0, 0, -1, -r.y(), r.x(), 0;
  return J;
}

NormalEquations Factor::linearize(const Eigen::Vector3d& mean_map, const Eigen::Vector3d& from_sensor,
                                  const RobustKernel& kernel) const {
  const Eigen::Vector3d residual = match.mean_leaf - mean_map;
  const double mahalanobis_squared = residual.dot(match.information * residual);
  const double weight = trust * kernel.weight(mahalanobis_squared);
  const Twist row = jacobian(from_sensor).transpose() * normal;
  const bool is_inlier = mahalanobis_squared < kChiSquared95;
  return {weight * stiffness * row * row.transpose(), weight * stiffness * normal.dot(residual) * row, 1,
          is_inlier ? 1U : 0U, is_inlier ? mahalanobis_squared : 0};
}

Factor make_factor(const Correspondence& match, double count) {
  Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d> eigen;
  eigen.computeDirect(match.information);
  const Eigen::Vector3d& lambda = eigen.eigenvalues();  // ascending
  return {match, eigen.eigenvectors().col(2), lambda[2] - std::max(0.0, lambda[1]),
          std::sqrt(count) * match.occupancy};
}

}  // namespace evermap
