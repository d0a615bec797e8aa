// SPDX-FileCopyrightText: 2026 the evermap authors
// SPDX-License-Identifier: BSD-3-Clause
#include <Eigen/Cholesky>

#include <evermap/localization/detail/solver.hpp>

namespace evermap {

Twist solve(const NormalEquations& equations, const Directions& directions, double damping) {
  Eigen::MatrixXd damped = directions.transpose() * equations.hessian * directions;
  damped.diagonal() *= 1 + damping;
  const Eigen::LDLT<Eigen::MatrixXd> factorized(damped);
  if (factorized.info() != Eigen::Success || !factorized.isPositive()) return Twist::Zero();
  const Twist step = -directions * factorized.solve(directions.transpose() * equations.gradient);
  return step.allFinite() ? step : Twist::Zero();
}

}  // namespace evermap
