// SPDX-FileCopyrightText: 2026 the evermap authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <evermap/update/detail/rules.hpp>

namespace evermap {

/// All that governs an update. The defaults are the default mode; `paper()` is the paper's.
struct UpdateParameters {
  ImpactRule impact = ImpactRule::kClosestApproach;
  Combination combination = Combination::kNoisyOr;
  bool spare_reobserved = true;  ///< a leaf is spared when the scan shows its surface in a neighbouring voxel
  bool surface_crossing = true;  ///< a flat leaf is contradicted only by a ray that ends beyond its plane
  bool trim_leaves = false;      ///< rays take from a leaf's geometry, too: the paper's equation 6
  double least_impact = 0.1;     ///< in [0, 1]; smaller impacts are ignored
  double extent_prior = 1;       ///< [points] weight of not knowing where in its voxel a surface is
  double patch_radius = 1.732;   ///< [standard deviations] so near to its middle, a flat leaf covers its
                                 ///< plane: sqrt(3) is the rim of what is spread evenly
  double hit_margin = 100;       ///< [alignment errors] before its hit, a ray contradicts no leaf without
                                 ///< a plane
  double surface_tolerance = 9;  ///< [alignment errors] by which a surface may seem displaced

  double hit = 2.197;                 ///< [log-odds] gained by one hit, logit(0.9)
  double miss = 1.386;                ///< [log-odds] lost by one full contradiction, -logit(0.2)
  double max_log_odds = 3;            ///< of a survey or of few hits: three full contradictions delete a leaf
  double long_term_hit = 1;           ///< [log-odds] gained by each further hit, up to
  double long_term_max_log_odds = 9;  ///< what only many scans can tell
  int confirmations = 3;              ///< [scans] that must hit a new leaf before it is occupied
  double max_count = 1000;            ///< [points] that a leaf remembers: older surface is forgotten
  double settled = 3;                 ///< [standard deviations] a known surface that a hit shows so near
                                      ///< to where it was stays there; 0: every hit moves it
  double forgetting = 0.5;            ///< fraction of these that one full contradiction takes

  double rim_gone = 0.5;  ///< fraction of the rim of a region of surface beside leaves that went, with which
                          ///< the region goes as a whole; 0: never
  double standstill = 0.1;  ///< [m] a sensor that moved less sees the same again (Viewpoint); 0: never

  static UpdateParameters paper();
};

inline UpdateParameters UpdateParameters::paper() {
  UpdateParameters parameters;
  parameters.impact = ImpactRule::kEquation5Inverse;
  parameters.combination = Combination::kMaximum;
  parameters.spare_reobserved = false;
  parameters.surface_crossing = false;
  parameters.trim_leaves = true;
  parameters.least_impact = 0;
  parameters.extent_prior = 0;
  parameters.patch_radius = 0;
  parameters.hit_margin = 0;
  parameters.max_log_odds = 3.5;
  parameters.long_term_hit = 0;
  parameters.confirmations = 1;
  parameters.max_count = 100;
  parameters.settled = 0;
  parameters.forgetting = 0;
  parameters.rim_gone = 0;
  parameters.standstill = 0;
  return parameters;
}

}  // namespace evermap
