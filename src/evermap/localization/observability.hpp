// SPDX-FileCopyrightText: 2026 the evermap authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <string>

#include <evermap/localization/factor.hpp>

namespace evermap {

/// How exactly a pose is to be known in every direction; what is known less well is unobservable.
struct AccuracyLimits {
  double translation = 0.017;  ///< [m] standard deviation; three of them make 5 cm
  double rotation = 0.003;     ///< [rad] likewise, half a degree
};

/// What the surroundings say about a pose, and in which directions they say nothing.
struct Observability {
  Matrix6 covariance =
      Matrix6::Zero();  ///< of the twist of perturb(), within the observable directions [m, rad]
  Matrix6 directions = Matrix6::Identity();  ///< of twists, in columns, the least known first
  int unobservable = 6;                      ///< directions
  double worst = 0;  ///< standard deviation of the weakest direction in units of its limit; 0: no information
  bool is_rotation = false;  ///< the weakest: about the axis through the sensor, else along it
  Eigen::Vector3d axis = Eigen::Vector3d::UnitX();  ///< of length 1, map frame

  bool is_complete() const { return unobservable == 0; }
};

/// The accuracy that results from `information` (see Factor). `noise`: variance of residuals in units of what
/// their covariances say.
Observability observability(const Matrix6& information, double noise, const AccuracyLimits& limits);

/// "translation along x", "rotation about (0.71, 0.70, 0.00)".
std::string to_string(const Observability& direction);

}  // namespace evermap
