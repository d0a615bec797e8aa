// SPDX-FileCopyrightText: 2026 the evermap authors
// SPDX-License-Identifier: BSD-3-Clause
#include <algorithm>
#include <cmath>

#include <evermap/update/detail/impact.hpp>
#include <evermap/update/detail/leaf_update.hpp>

namespace evermap {
namespace {

/// Log-odds of a leaf after its first hit: `confirmations` hits make it positive.
double first_hit(const UpdateParameters& parameters) {
  return parameters.hit * (2 - parameters.confirmations);
}

/// Log-odds after one more hit: full steps to what a few scans can tell, small ones beyond.
double raised(double log_odds, const UpdateParameters& parameters) {
  if (log_odds < parameters.max_log_odds) return std::min(log_odds + parameters.hit, parameters.max_log_odds);
  return std::min(log_odds + parameters.long_term_hit,
                  std::max(parameters.long_term_max_log_odds, parameters.max_log_odds));
}

/// A known surface and what a hit adds to it. The pose of a scan was found by the surfaces that it hits, so
/// it cannot tell them where they are: what is seen where it was stays there, or the map would follow the
/// errors of the poses. Across its plane, a flat leaf counts as seen when a hit is off it by no more than
/// noise and `error` [m] explain; another leaf, when a hit lies within it.
Gaussian united(const Gaussian& known, const Gaussian& hit, double error,
                const UpdateParameters& parameters) {
  Gaussian both = merge(known, hit);
  const double bound = parameters.settled * parameters.settled;
  const Plane plane = plane_of(known);
  if (!plane.flat) {
    const bool is_within = mahalanobis_squared(hit.mean, known) < bound;
    return is_within ? Gaussian{known.mean, known.covariance, both.count} : both;
  }
  const Eigen::Vector3d& n = plane.normal;
  const double variance = plane.sigma * plane.sigma;
  const double apart = n.dot(hit.mean - known.mean);
  const double noise = error * error + variance / known.count + n.dot(hit.covariance * n) / hit.count;
  if (apart * apart > bound * noise) return both;
  const Eigen::Matrix3d within = plane.within();
  both.mean -= n.dot(both.mean - known.mean) * n;
  both.covariance = within * both.covariance * within + variance * n * n.transpose();
  return both;
}

}  // namespace

void confirm(Leaf& leaf, const Gaussian& bundle, const Eigen::Vector3d& center_map, double error,
             const UpdateParameters& parameters) {
  const bool is_new = leaf.count <= 0;
  const bool is_known =
      parameters.settled > 0 && leaf.log_odds >= static_cast<float>(parameters.max_log_odds);
  Gaussian surface = bundle;
  if (!is_new) {
    const Gaussian before = leaf.gaussian(center_map);
    surface = is_known ? united(before, bundle, error, parameters) : merge(before, bundle);
  }
  surface.count = std::min(surface.count, parameters.max_count);
  leaf.set_gaussian(surface, center_map);
  constexpr double kAlmostZero = 1e-5;  // of stored log-odds: it must not turn the last 0 into occupied
  const double log_odds = is_new ? std::min(first_hit(parameters), parameters.max_log_odds)
                                 : raised(static_cast<double>(leaf.log_odds), parameters);
  leaf.log_odds = std::abs(log_odds) < kAlmostZero ? 0 : static_cast<float>(log_odds);
}

bool contradict(Leaf& leaf, double impact, const UpdateParameters& parameters) {
  const bool was_occupied = leaf.occupied();
  leaf.log_odds = static_cast<float>(leaf.log_odds - impact * parameters.miss);
  // The next hits outweigh what is in doubt. A count of 0 would say that the leaf is new.
  const auto count = static_cast<double>(leaf.count);
  const double trusted = std::max(std::min(count, 1.0), count * (1 - impact * parameters.forgetting));
  leaf.count = static_cast<float>(trusted);
  return was_occupied ? leaf.occupied() : leaf.log_odds >= static_cast<float>(first_hit(parameters));
}

}  // namespace evermap
