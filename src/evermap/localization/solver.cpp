// SPDX-FileCopyrightText: 2026 the evermap authors
// SPDX-License-Identifier: BSD-3-Clause
#include <Eigen/Cholesky>

#include <evermap/localization/detail/solver.hpp>

namespace evermap {

Twist solve(const NormalEquations& equations, double damping) {
  Matrix6 damped = equations.hessian;
  damped.diagonal() *= 1 + damping;
  const Eigen::LDLT<Matrix6> factorized(damped);
  if (factorized.info() != Eigen::Success || !factorized.isPositive()) return Twist::Zero();
  const Twist step = -factorized.solve(equations.gradient);
  return step.allFinite() ? step : Twist::Zero();
}

}  // namespace evermap
