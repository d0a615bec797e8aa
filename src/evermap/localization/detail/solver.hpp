// SPDX-FileCopyrightText: 2026 the evermap authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <evermap/geometry/pose.hpp>
#include <evermap/localization/detail/factor.hpp>

namespace evermap {

/// Levenberg's step: the twist that minimizes the linearized sum, held back a little (`damping` of each
/// diagonal element) so that directions which nothing observes stay where they are. Zero when there are no
/// equations.
Twist solve(const NormalEquations& equations, double damping);

}  // namespace evermap
