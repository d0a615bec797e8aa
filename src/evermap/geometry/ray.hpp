// SPDX-FileCopyrightText: 2026 the evermap authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <Eigen/Core>

namespace evermap {

/// The straight path of a laser beam, from the sensor to what it hit; both ends in the map frame.
struct Ray {
  Eigen::Vector3d origin;  ///< [m]
  Eigen::Vector3d end;     ///< [m]

  double length() const { return (end - origin).norm(); }  ///< [m]
};

}  // namespace evermap
