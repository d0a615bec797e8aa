// SPDX-FileCopyrightText: 2026 the evermap authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <string>

#include <evermap/localization/detail/factor.hpp>

namespace evermap {

/// How well the surroundings hold a pose, in the direction in which they hold it worst.
struct Observability {
  double fraction = 0;                              ///< of the information in the mean direction; in [0, 1]
  bool is_rotation = false;                         ///< about the axis through the sensor, else along it
  Eigen::Vector3d axis = Eigen::Vector3d::UnitX();  ///< of length 1, map frame
};

/// `hessian`: of what surfaces say about the pose. `lever`: [m] typical distance of what is seen, which makes
/// turns comparable to shifts.
Observability observability(const Matrix6& hessian, double lever);

/// "translation along x", "rotation about (0.71, 0.70, 0.00)".
std::string to_string(const Observability& direction);

}  // namespace evermap
