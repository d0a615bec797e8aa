// SPDX-FileCopyrightText: 2026 the evermap authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <evermap/scan/ray_bundle.hpp>

namespace evermap {

/// How a ray's contradiction of a leaf is measured.
enum class ImpactRule {
  kEquation5Inverse,  ///< the paper's equation 5, third case falling with distance (the text's reading)
  kEquation5Printed,  ///< the paper's equation 5, third case as printed, clamped to 1
  kClosestApproach,   ///< likelihood of the mean ray's closest approach to the leaf's Gaussian
};

/// How the impacts of all bundles of one scan become one occupancy step.
enum class Combination { kMaximum, kNoisyOr };

/// Which evidence in the same scan spares a leaf that a ray contradicts.
enum class SurfaceGuard {
  kNone,
  kCoplanarHit,  ///< a neighbouring voxel was hit on the same plane: the ray grazes a surface that is there
  kReobserved,   ///< the leaf's mean lies in a neighbouring bundle, allowing for the scan's alignment error
};

/// What a contradicting ray takes from a leaf's Gaussian.
enum class Difference {
  kNone,
  kSigmaPoints,  ///< the paper: refit the sigma points outside the bundle's 95 % ellipsoid
  kSoft,         ///< subtract the bundle's cylinder in closed form
};

/// All that governs an update. The defaults are the default mode; `paper()` is the paper's.
struct UpdateParameters {
  LidarParameters lidar;

  ImpactRule impact = ImpactRule::kClosestApproach;
  Combination combination = Combination::kNoisyOr;
  SurfaceGuard surface_guard = SurfaceGuard::kReobserved;
  Difference difference = Difference::kNone;
  bool surface_crossing = true;   ///< a planar leaf is contradicted only by a ray that ends beyond its plane
  bool incidence_weight = false;  ///< weigh a planar leaf's impact by |cos| of the angle of incidence
  double least_impact = 0.1;      ///< smaller impacts are ignored
  double end_guard = 100;         ///< how far before its hit a ray contradicts no leaf without a plane, and
  double displacement = 9;        ///< how far a surface may seem displaced, both in units of the scan's
                                  ///< alignment error

  double hit = 2.197;        ///< log-odds of one hit, logit(0.9)
  double miss = 1.386;       ///< log-odds taken by one full contradiction, -logit(0.2)
  double max_log_odds = 3;   ///< of a survey or of few hits, so that three full contradictions delete a leaf
  double firming = 1;        ///< log-odds of each further hit, up to
  double firm_log_odds = 9;  ///< which only many scans can tell: foliage and edges, hit and passed in turns
  int confirmations = 3;     ///< scans that must hit a new leaf before it is occupied
  double max_count = 1000;   ///< [points] a leaf's memory: older surface is forgotten beyond
  double forgetting = 0.5;   ///< share in [0, 1] of this memory that one full contradiction takes

  double standstill = 0.1;  ///< [m] a sensor that moved less sees the same again (Viewpoint); 0: never

  static UpdateParameters paper();
};

inline UpdateParameters UpdateParameters::paper() {
  UpdateParameters parameters;
  parameters.impact = ImpactRule::kEquation5Inverse;
  parameters.combination = Combination::kMaximum;
  parameters.surface_guard = SurfaceGuard::kNone;
  parameters.difference = Difference::kSigmaPoints;
  parameters.surface_crossing = false;
  parameters.least_impact = 0;
  parameters.end_guard = 0;
  parameters.max_log_odds = 3.5;
  parameters.firming = 0;
  parameters.confirmations = 1;
  parameters.max_count = 100;
  parameters.forgetting = 0;
  parameters.standstill = 0;
  return parameters;
}

}  // namespace evermap
