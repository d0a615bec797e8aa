// SPDX-FileCopyrightText: 2026 the evermap authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <evermap/geometry/pose.hpp>
#include <evermap/localization/detail/factor.hpp>

namespace evermap {

/// Twists that a step may be made of, in columns.
using Directions = Eigen::Matrix<double, 6, Eigen::Dynamic, Eigen::ColMajor, 6, 6>;

/// Levenberg's step: the twist, made of `directions`, that minimizes the linearized sum, held back a little
/// (`damping` of each diagonal element). Zero when there are no equations.
Twist solve(const NormalEquations& equations, const Directions& directions, double damping);

}  // namespace evermap
