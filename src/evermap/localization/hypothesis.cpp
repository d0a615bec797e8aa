// SPDX-FileCopyrightText: 2026 the evermap authors
// SPDX-License-Identifier: BSD-3-Clause
#include <algorithm>
#include <numbers>
#include <tuple>
#include <utility>

#include <Eigen/Cholesky>

#include <evermap/localization/detail/hypothesis.hpp>
#include <evermap/localization/detail/perturbation.hpp>

namespace evermap {
namespace {

/// Whether two hypotheses are of one place: `better` lies within what `other` leaves open, or where it would
/// be had it been deskewed by the other's velocity.
bool is_one_place(const Hypothesis& better, const Hypothesis& other, double scan_period) {
  constexpr double kSigmas = 4;
  constexpr double kShift = 0.02;                         // [m] where registration may come to rest
  constexpr double kTurn = 0.2 * std::numbers::pi / 180;  // [rad] likewise
  const Twist skew = scan_period / 2 * (better.motion.after - other.motion.after);
  const Matrix6 least = within(kShift + skew.head<3>().norm(), kTurn + skew.tail<3>().norm());
  const Twist off = difference(other.registration.T_map_sensor, better.registration.T_map_sensor);
  return off.dot((other.registration.covariance + least).ldlt().solve(off)) < kSigmas * kSigmas;
}

}  // namespace

std::vector<Hypothesis> distinct(std::vector<Hypothesis> found, double scan_period) {
  const auto rank = [](const Hypothesis& at) {
    return std::tuple(!at.registration.converged(), at.registration.unobservable, -at.score());
  };
  std::stable_sort(found.begin(), found.end(),
                   [&](const Hypothesis& a, const Hypothesis& b) { return rank(a) < rank(b); });
  std::vector<Hypothesis> places;
  for (Hypothesis& next : found) {
    const bool is_known = std::any_of(places.begin(), places.end(), [&](const Hypothesis& place) {
      return !next.registration.converged() || is_one_place(place, next, scan_period);
    });
    if (!is_known) places.push_back(std::move(next));
  }
  return places;
}

std::size_t best_of(const std::vector<Hypothesis>& hypotheses) {
  const auto best =
      std::max_element(hypotheses.begin(), hypotheses.end(),
                       [](const Hypothesis& a, const Hypothesis& b) { return a.score() < b.score(); });
  return static_cast<std::size_t>(best - hypotheses.begin());
}

bool has_rival(const std::vector<Hypothesis>& hypotheses, std::size_t best, double margin) {
  const Hypothesis& winner = hypotheses[best];
  const double enough = winner.score() - margin * winner.registration.explained_fraction();
  for (std::size_t i = 0; i < hypotheses.size(); ++i) {
    const Hypothesis& other = hypotheses[i];
    if (i != best && other.registration.converged() && other.score() > enough) return true;
  }
  return false;
}

}  // namespace evermap
