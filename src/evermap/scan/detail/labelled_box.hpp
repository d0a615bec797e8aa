// SPDX-FileCopyrightText: 2026 the evermap authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <Eigen/Core>

namespace evermap {

/// A labelled object of one scan: an upright box in the sensor frame.
struct LabelledBox {
  enum class Motion { kUncertain = -1, kParked = 0, kMoving = 1 };

  Eigen::Vector3d center_sensor;  ///< [m]
  Eigen::Vector3d size;           ///< [m] length, width, height
  double yaw;                     ///< [rad] of the length axis about z
  Motion motion;
};

}  // namespace evermap
