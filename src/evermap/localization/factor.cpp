// SPDX-FileCopyrightText: 2026 the evermap authors
// SPDX-License-Identifier: BSD-3-Clause
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

NormalEquations factor(const Correspondence& match, const Eigen::Vector3d& from_sensor, double weight) {
  const Eigen::Matrix<double, 3, 6> J = jacobian(from_sensor);
  const Eigen::Matrix<double, 6, 3> wJtM = weight * J.transpose() * match.information;
  const bool is_inlier = match.mahalanobis_squared < kChiSquared95;
  return {wJtM * J, wJtM * match.residual, 1, is_inlier ? 1U : 0U, is_inlier ? match.mahalanobis_squared : 0};
}

}  // namespace evermap
