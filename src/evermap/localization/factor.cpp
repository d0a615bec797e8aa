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
  asked += other.asked;
  agreed += other.agreed;
  return *this;
}

double NormalEquations::mean_inlier_error() const {
  return inlier_error / std::max(1.0, static_cast<double>(inliers));
}

Twist jacobian(const Eigen::Vector3d& normal, const Eigen::Vector3d& from_sensor) {
  return (Twist() << -normal, normal.cross(from_sensor)).finished();
}

void Factor::pull(NormalEquations& equations, double off, const Eigen::Vector3d& from_sensor,
                  double weight) const {
  const Twist row = jacobian(match.normal, from_sensor);
  const Twist weighted = trust * weight * stiffness * row;
  equations.hessian += weighted * row.transpose();
  equations.gradient += off * weighted;
}

void Factor::add_to(NormalEquations& equations, const Eigen::Vector3d& mean_map,
                    const Eigen::Vector3d& from_sensor, const RobustKernel& kernel) const {
  const Eigen::Vector3d residual = match.mean_leaf - mean_map;
  const double mahalanobis_squared = residual.dot(match.information * residual);
  const double off = match.normal.dot(residual);
  pull(equations, off, from_sensor, kernel.weight(mahalanobis_squared));
  equations.asked += trust;
  ++equations.matched;
  if (mahalanobis_squared >= kChiSquared95) return;
  ++equations.inliers;
  equations.inlier_error += mahalanobis_squared;
  equations.agreed += trust * kernel.weight(off * off * match.normal.dot(match.information * match.normal));
}

std::optional<Factor> make_factor(const Correspondence& match, double count) {
  constexpr double kNarrow = 0.05;  // [m] standard deviations: what is narrower than this, and
  constexpr double kLong = 4;       // so many times longer, is a line
  const Eigen::Matrix3d& M = match.information;
  const Eigen::Vector3d& normal = match.normal;
  const double trace = M.trace();
  const double stiffest = normal.dot(M * normal);
  // Of the other two eigenvalues, the sum and the product are known.
  const double half_sum = (trace - stiffest) / 2;
  const double product = M.determinant() / stiffest;
  const double next = half_sum + std::sqrt(std::max(0.0, half_sum * half_sum - product));
  const double softest = trace - stiffest - next;
  if (next * kNarrow * kNarrow > 1 && next > kLong * kLong * softest) return std::nullopt;
  return Factor{match, std::max(0.0, stiffest - next), std::sqrt(count) * match.occupancy};
}

}  // namespace evermap
