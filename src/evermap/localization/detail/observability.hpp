// SPDX-FileCopyrightText: 2026 the evermap authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <string>

#include <Eigen/Core>

#include <evermap/geometry/pose.hpp>

namespace evermap {

using Matrix6 = Eigen::Matrix<double, 6, 6>;

/// The direction in which a pose is known least. Turns compare with shifts by what they move 10 m away.
struct WeakestDirection {
  double sigma = 0;                                 ///< standard deviation [m], or [rad] of a turn
  bool is_rotation = false;                         ///< about the axis through the sensor, else along it
  Eigen::Vector3d axis = Eigen::Vector3d::UnitX();  ///< of length 1, map frame
};

/// `covariance`: [m, rad] of the twist of perturb().
WeakestDirection weakest_direction(const Matrix6& covariance);

/// "translation along x", "rotation about (0.71, 0.70, 0.00)".
std::string to_string(const WeakestDirection& direction);

/// Twists that a pose may be moved along, in columns.
using Directions = Eigen::Matrix<double, 6, Eigen::Dynamic>;

/// Before and after a scan was registered, what is known of its pose.
///
/// Where surfaces say less than is known before (along an endless corridor, a turn on a plain), they are not
/// asked: they would pull the pose to where noise says. Zhang, Kaess and Singh (2016) call it solution
/// remapping; their threshold on eigenvalues is here what was known.
struct Knowledge {
  Matrix6 covariance;     ///< after
  Directions directions;  ///< those of which surfaces say more
};

/// `information`: what surfaces say; not necessarily positive in any direction. `covariance`: known before.
Knowledge learn(const Matrix6& information, const Matrix6& covariance);

}  // namespace evermap
