// SPDX-FileCopyrightText: 2026 the evermap authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <optional>

#include <Eigen/Core>

#include <evermap/geometry/pose.hpp>

namespace evermap {

/// `count` points, known by their mean and covariance (scatter / count). All of the map's arithmetic on
/// Gaussians is here and nowhere else.
struct Gaussian {
  Eigen::Vector3d mean = Eigen::Vector3d::Zero();        ///< [m]
  Eigen::Matrix3d covariance = Eigen::Matrix3d::Zero();  ///< [m^2] symmetric, positive semi-definite
  double count = 0;                                      ///< points, or their weight once forgetting set in
};

/// 95 % and 99 % quantiles of chi-squared with 3 degrees of freedom: the squared radii of the confidence
/// ellipsoids.
inline constexpr double kChiSquared95 = 7.814727903251179;
inline constexpr double kChiSquared99 = 11.344866730144373;

/// The Gaussian of points of frame a, seen from frame b.
Gaussian transform(const Pose& T_b_a, const Gaussian& a);

/// The Gaussian of both sets of points together (moment matching).
Gaussian merge(const Gaussian& a, const Gaussian& b);

/// The Gaussian of `all` without its subset `part`: the inverse of merge. None when nothing, or nothing with
/// a positive semi-definite covariance, would be left.
std::optional<Gaussian> remove(const Gaussian& all, const Gaussian& part);

/// (x - mean)' covariance^-1 (x - mean). REQUIRES: covariance is positive definite.
double mahalanobis_squared(const Eigen::Vector3d& x, const Gaussian& gaussian);

/// Kullback-Leibler divergence D(p || q) [nat]. REQUIRES: both covariances are positive definite.
double kl_divergence(const Gaussian& p, const Gaussian& q);

/// `covariance` with each eigenvalue raised to at least `floor` [m^2].
Eigen::Matrix3d floor_eigenvalues(const Eigen::Matrix3d& covariance, double floor);

}  // namespace evermap
