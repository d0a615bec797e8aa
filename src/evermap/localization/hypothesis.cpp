// SPDX-FileCopyrightText: 2026 the evermap authors
// SPDX-License-Identifier: BSD-3-Clause
#include <algorithm>

#include <Eigen/LU>

#include <evermap/localization/hypothesis.hpp>
#include <evermap/localization/perturbation.hpp>

namespace evermap {
namespace {

constexpr double kSamePlace = 0.05;      ///< [m] poses nearer than this are one place
constexpr double kSameHeading = 0.0087;  ///< [rad] half a degree
constexpr double kRivalScore = 0.9;      ///< of the best score

}  // namespace

bool is_same_place(const Registration& a, const Registration& b) {
  Twist apart = difference(a.T_map_sensor, b.T_map_sensor);
  const Observability& known = a.observability;
  const Twist along = known.directions.fullPivLu().solve(apart);
  apart -= known.directions.leftCols(known.unobservable) * along.head(known.unobservable);
  return apart.head<3>().norm() < kSamePlace && apart.tail<3>().norm() < kSameHeading;
}

std::vector<Hypothesis> distinct(const std::vector<Registration>& found) {
  std::vector<Hypothesis> places;
  for (const Registration& next : found) {
    if (!next.is_usable()) continue;
    const auto same = std::find_if(places.begin(), places.end(), [&](const Hypothesis& place) {
      return is_same_place(place.registration, next);
    });
    if (same == places.end()) {
      places.push_back({next});
    } else if (next.explained() > 1.001 * same->registration.explained()) {
      same->registration = next;
    }
  }
  if (places.empty() && !found.empty()) places.push_back({found.front()});
  return places;
}

std::size_t best_of(const std::vector<Hypothesis>& hypotheses) {
  const auto best =
      std::max_element(hypotheses.begin(), hypotheses.end(),
                       [](const Hypothesis& a, const Hypothesis& b) { return a.score() < b.score(); });
  return static_cast<std::size_t>(best - hypotheses.begin());
}

bool has_rival(const std::vector<Hypothesis>& hypotheses, std::size_t best) {
  const double most = hypotheses[best].score();
  for (std::size_t i = 0; i < hypotheses.size(); ++i) {
    if (i != best && hypotheses[i].score() > kRivalScore * most) return true;
  }
  return false;
}

}  // namespace evermap
