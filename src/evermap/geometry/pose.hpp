// SPDX-FileCopyrightText: 2026 the evermap authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <Eigen/Core>
#include <Eigen/Geometry>

namespace evermap {

/// Rigid transform T_a_b: maps coordinates of frame b to frame a, `p_a = T_a_b * p_b`.
///
/// Class invariant: `rotation` is orthonormal with determinant +1 (`is_rotation`); the io layer checks it
/// where poses enter the program.
struct Pose {
  Eigen::Matrix3d rotation = Eigen::Matrix3d::Identity();
  Eigen::Vector3d translation = Eigen::Vector3d::Zero();  ///< [m]

  Eigen::Vector3d operator*(const Eigen::Vector3d& p_b) const { return rotation * p_b + translation; }
  Pose operator*(const Pose& T_b_c) const {
    return {rotation * T_b_c.rotation, rotation * T_b_c.translation + translation};
  }
  Pose inverse() const { return {rotation.transpose(), -(rotation.transpose() * translation)}; }
};

/// True when `matrix` is orthonormal within `tolerance` and right-handed.
bool is_rotation(const Eigen::Matrix3d& matrix, double tolerance);

/// The rotation nearest to `matrix` in the Frobenius norm. REQUIRES: matrix is finite and of full rank.
Eigen::Matrix3d nearest_rotation(const Eigen::Matrix3d& matrix);

/// SE(3) exponential and logarithm; a twist is (translation [m], rotation [rad]).
using Twist = Eigen::Matrix<double, 6, 1>;
Pose exp(const Twist& twist);
Twist log(const Pose& pose);

}  // namespace evermap
