// SPDX-FileCopyrightText: 2026 the evermap authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

namespace evermap {

/// How a ray's contradiction of a leaf is measured.
enum class ImpactRule {
  kClosestApproach,   ///< likelihood of the leaf's Gaussian where the mean ray comes closest to it
  kEquation5Inverse,  ///< the paper's equation 5, its third case falling with distance (the text's reading)
  kEquation5Printed,  ///< the paper's equation 5, its third case as printed, clamped to 1
};

/// How the impacts of all bundles of one scan become one occupancy step.
enum class Combination { kMaximum, kNoisyOr };

}  // namespace evermap
