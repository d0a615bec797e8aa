// SPDX-FileCopyrightText: 2026 the evermap authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <evermap/geometry/pose.hpp>

namespace evermap {

/// When the search for a pose is over; what is left is for refining it.
struct Termination {
  int max_iterations = 40;
  double least_translation = 3e-3;  ///< [m] a shorter step changes nothing that refining would not
  double least_rotation = 3e-4;     ///< [rad]

  bool is_settled(const Twist& step) const {
    return step.head<3>().norm() < least_translation && step.tail<3>().norm() < least_rotation;
  }
};

}  // namespace evermap
