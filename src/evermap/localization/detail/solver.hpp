// SPDX-FileCopyrightText: 2026 the evermap authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <evermap/geometry/pose.hpp>
#include <evermap/localization/detail/factor.hpp>

namespace evermap {

/// Levenberg's step: of the twists along `directions` (columns) that which minimizes the linearized sum, held
/// back a little, by `damping` of each diagonal element. Zero when there are no equations.
Twist solve(const NormalEquations& equations, const Directions& directions, double damping);

}  // namespace evermap
