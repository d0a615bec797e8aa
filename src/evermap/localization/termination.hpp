// SPDX-FileCopyrightText: 2026 the evermap authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <evermap/geometry/pose.hpp>

namespace evermap {

/// When iterating is over.
struct Termination {
  int max_iterations = 40;
  double least_translation = 5e-4;  ///< [m] a shorter step changes nothing that matters
  double least_rotation = 5e-5;     ///< [rad]

  bool is_settled(const Twist& step) const {
    return step.head<3>().norm() < least_translation && step.tail<3>().norm() < least_rotation;
  }
};

}  // namespace evermap
