// SPDX-FileCopyrightText: 2026 the evermap authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <vector>

#include <evermap/localization/detail/registration.hpp>

namespace evermap {

/// A place where a scan may be, and what speaks against it.
struct Hypothesis {
  Registration registration;
  double contradicting = 0;  ///< fraction of the scan's rays that contradict the map there; in [0, 1]

  /// What the map explains less what it is contradicted by; in [-1, 1].
  double score() const { return registration.explained() - contradicting; }
};

/// Whether two registrations found the same place, within what a pose that is wrong may be off. Directions
/// that neither knows do not count.
bool is_same_place(const Registration& a, const Registration& b);

/// Of registrations that found the same place, the one that explains most; those that found none are left
/// out, unless all did. The order stays.
std::vector<Hypothesis> distinct(const std::vector<Registration>& found);

/// Index of the one that scores best. REQUIRES: there is one.
std::size_t best_of(const std::vector<Hypothesis>& hypotheses);
/// Whether another one scores about as well as that.
bool has_rival(const std::vector<Hypothesis>& hypotheses, std::size_t best);

}  // namespace evermap
