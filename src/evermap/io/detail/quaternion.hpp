// SPDX-FileCopyrightText: 2026 the evermap authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cmath>
#include <optional>

#include <Eigen/Core>
#include <Eigen/Geometry>

namespace evermap {

/// How far the norm of a quaternion in a file may be from 1: enough for three printed digits.
inline constexpr double kQuaternionNormTolerance = 1e-2;

/// The rotation of a quaternion read from a file, normalized; none when its norm is not 1 within tolerance.
inline std::optional<Eigen::Matrix3d> rotation_from_file(const Eigen::Quaterniond& quaternion) {
  const double error = std::abs(quaternion.norm() - 1.0);
  if (!(error <= kQuaternionNormTolerance)) return std::nullopt;  // NaN compares false
  return quaternion.normalized().toRotationMatrix();
}

}  // namespace evermap
