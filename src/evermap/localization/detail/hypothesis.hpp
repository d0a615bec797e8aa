// SPDX-FileCopyrightText: 2026 the evermap authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstddef>
#include <vector>

#include <evermap/localization/detail/registration.hpp>
#include <evermap/scan/detail/deskew.hpp>

namespace evermap {

/// A place where a scan may be, and what speaks for it.
struct Hypothesis {
  Registration registration;
  Scan scan;                          ///< deskewed as the sensor moved to get there
  ScanMotion motion = {};             ///< by which it was
  double contradicting_fraction = 0;  ///< of the scan's rays there: they cross what the map believes in

  /// Registration::score(), less the rays that go through leaves.
  double score() const { return registration.score() - contradicting_fraction; }
};

/// One hypothesis for each place: of those that may be one, that which leaves fewer directions open, or else
/// explains more. What did not converge is a hypothesis only when nothing did.
std::vector<Hypothesis> distinct(std::vector<Hypothesis> found, double scan_period);

/// Index of the hypothesis with the best score. REQUIRES: there is one.
std::size_t best_of(const std::vector<Hypothesis>& hypotheses);

/// Whether another place scores nearly as well as the best: by less than `margin` of what the best explains.
bool has_rival(const std::vector<Hypothesis>& hypotheses, std::size_t best, double margin);

}  // namespace evermap
