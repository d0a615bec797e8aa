// SPDX-FileCopyrightText: 2026 the evermap authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cmath>
#include <cstdint>
#include <span>
#include <vector>

#include <evermap/map/octree.hpp>
#include <evermap/scan/detail/ray_bundle.hpp>
#include <evermap/update/parameters.hpp>

namespace evermap {

/// One bundle's ray passes through a leaf and contradicts it.
struct Contradiction {
  VoxelKey leaf;
  std::uint32_t bundle;  ///< index into BundleGrid::bundles()
  float impact;          ///< in [0, 1]; 0 when the leaf's surroundings tell that the ray passed it by
};

/// All that one scan says against one leaf.
struct LeafEvidence {
  VoxelKey leaf;
  double impact;        ///< in [0, 1] of all its contradictions together; 0 when the leaf is spared
  std::uint32_t begin;  ///< its contradictions: a range of Evidence::contradictions
  std::uint32_t end;

  /// Its contradictions among Evidence::contradictions.
  template <class Contradictions>
  auto among(Contradictions& all) const {
    return std::span(all).subspan(begin, end - begin);
  }
};

/// How far a scan is off the map. What is off by its direction is the farther off the farther away it is.
struct AlignmentError {
  double position = 0;   ///< [m]
  double direction = 0;  ///< [rad]

  /// Standard deviation of a point's place [m] at this range [m].
  double at(double range) const { return std::hypot(position, direction * range); }
};

/// What a scan says against the map. Leaves ascend by key; a leaf's contradictions follow the order of
/// bundles.
struct Evidence {
  std::vector<Contradiction> contradictions;
  std::vector<LeafEvidence> leaves;
  AlignmentError alignment_error;  ///< of the scan, where the rules ask for it
};

/// Fraction of a scan's bundles that contradict leaves, each a leaf of its own: what is gone close to the
/// sensor is crossed by most rays wherever that is, and still is one leaf. Spared leaves do not count.
double contradicting_fraction(const Evidence& evidence, const BundleGrid& bundles);

/// How far the scan is off the map: robust standard deviations of the distances from the scan's bundles to
/// the planes of flat leaves that they hit, in the nearer and the farther half of these. It is measured, not
/// assumed, so that one rule serves exact poses and poor ones.
AlignmentError alignment_error(const Octree& octree, const BundleGrid& bundles);

/// Sends every bundle's ray through the map and gathers, leaf by leaf, what it contradicts. Reads the map and
/// writes nothing; runs in parallel in the caller's TBB arena, with the same result for any number of
/// threads.
Evidence trace(const Octree& octree, const BundleGrid& bundles, const UpdateParameters& parameters);

}  // namespace evermap
