// SPDX-FileCopyrightText: 2026 the evermap authors
// SPDX-License-Identifier: BSD-3-Clause
#include <algorithm>
#include <cmath>

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

}  // namespace

void confirm(Leaf& leaf, const Gaussian& bundle, const Eigen::Vector3d& center_map,
             const UpdateParameters& parameters) {
  const bool is_new = leaf.count <= 0;
  Gaussian surface = is_new ? bundle : merge(leaf.gaussian(center_map), bundle);
  surface.count = std::min(surface.count, parameters.max_count);
  leaf.set_gaussian(surface, center_map);
  constexpr double kRounding = 1e-5;  // of stored log-odds: it must not turn the last 0 into occupied
  const double log_odds = is_new ? std::min(first_hit(parameters), parameters.max_log_odds)
                                 : raised(static_cast<double>(leaf.log_odds), parameters);
  leaf.log_odds = std::abs(log_odds) < kRounding ? 0 : static_cast<float>(log_odds);
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
