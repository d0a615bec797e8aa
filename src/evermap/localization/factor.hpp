// SPDX-FileCopyrightText: 2026 the evermap authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstddef>

#include <Eigen/Core>

#include <evermap/geometry/pose.hpp>
#include <evermap/localization/correspondence.hpp>

namespace evermap {

using Matrix6 = Eigen::Matrix<double, 6, 6>;

/// What bundles say about the pose: minimize the sum of w e' M e, linearized in the twist of perturb().
struct NormalEquations {
  Matrix6 hessian = Matrix6::Zero();  ///< sum of w J' M J
  Twist gradient = Twist::Zero();     ///< sum of w J' M e
  std::size_t matched = 0;            ///< bundles with a leaf
  std::size_t inliers = 0;            ///< of these, within the 95 % ellipsoid
  double inlier_error = 0;            ///< sum of their squared Mahalanobis distances

  NormalEquations& operator+=(const NormalEquations& other);
};

/// J = de/dtwist = [-I, [r]x] for e = mu_V - mu_R, with r = mu_R - t the bundle as seen from the sensor.
Eigen::Matrix<double, 3, 6> jacobian(const Eigen::Vector3d& from_sensor);

/// One bundle's share in the equations. `from_sensor` [m]: from the sensor to the bundle, in the map's axes.
NormalEquations factor(const Correspondence& match, const Eigen::Vector3d& from_sensor, double weight);

}  // namespace evermap
