// SPDX-FileCopyrightText: 2026 the evermap authors
// SPDX-License-Identifier: BSD-3-Clause
#include <cmath>

#include <Eigen/Eigenvalues>
#include <Eigen/LU>

#include <evermap/geometry/gaussian.hpp>

namespace evermap {

Gaussian transform(const Pose& T_b_a, const Gaussian& a) {
  const Eigen::Matrix3d& R = T_b_a.rotation;
  return {T_b_a * a.mean, R * a.covariance * R.transpose(), a.count};
}

Gaussian merge(const Gaussian& a, const Gaussian& b) {
  const double count = a.count + b.count;
  const double share_b = b.count / count;
  const Eigen::Vector3d apart = b.mean - a.mean;
  return {a.mean + share_b * apart,
          (1 - share_b) * a.covariance + share_b * b.covariance +
              (1 - share_b) * share_b * apart * apart.transpose(),
          count};
}

std::optional<Gaussian> remove(const Gaussian& all, const Gaussian& part) {
  const double count = all.count - part.count;
  if (!(count > 0)) return std::nullopt;
  const double share_part = part.count / all.count;
  const double share_rest = 1 - share_part;
  const Eigen::Vector3d apart = (part.mean - all.mean) / share_rest;  // from the rest's mean to the part's
  Gaussian rest{
      all.mean - share_part * apart,
      (all.covariance - share_part * part.covariance) / share_rest - share_part * apart * apart.transpose(),
      count};
  // Rounding leaves a vanished variance at +-1e-16 of what was subtracted; below that the sets did not nest.
  const double rounding = 1e-9 * (all.covariance.trace() + part.covariance.trace());
  const Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d> eigen(rest.covariance);
  if (eigen.eigenvalues().minCoeff() < -rounding) return std::nullopt;
  return rest;
}

double mahalanobis_squared(const Eigen::Vector3d& x, const Gaussian& gaussian) {
  const Eigen::Vector3d from_mean = x - gaussian.mean;
  return from_mean.dot(gaussian.covariance.inverse() * from_mean);
}

double kl_divergence(const Gaussian& p, const Gaussian& q) {
  const Eigen::Matrix3d q_information = q.covariance.inverse();
  const Eigen::Vector3d apart = q.mean - p.mean;
  return 0.5 * ((q_information * p.covariance).trace() + apart.dot(q_information * apart) - 3 +
                std::log(q.covariance.determinant() / p.covariance.determinant()));
}

Eigen::Matrix3d floor_eigenvalues(const Eigen::Matrix3d& covariance, double floor) {
  // The common case: no eigenvalue is below the floor, the leading minors of the excess are positive.
  const Eigen::Matrix3d excess = covariance - floor * Eigen::Matrix3d::Identity();
  const double minor = excess(0, 0) * excess(1, 1) - excess(1, 0) * excess(0, 1);
  if (excess(0, 0) > 0 && minor > 0 && excess.determinant() > 0) return covariance;
  const Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d> eigen(covariance);
  return eigen.eigenvectors() * eigen.eigenvalues().cwiseMax(floor).asDiagonal() *
         eigen.eigenvectors().transpose();
}

}  // namespace evermap
