// SPDX-FileCopyrightText: 2026 the evermap authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstddef>

#include <evermap/geometry/pose.hpp>
#include <evermap/map/octree.hpp>
#include <evermap/scan/ray_bundle.hpp>
#include <evermap/scan/scan.hpp>
#include <evermap/update/evidence.hpp>
#include <evermap/update/parameters.hpp>

namespace evermap {

/// What became of one scan's points.
struct ScanSummary {
  std::size_t points = 0;  ///< of the scan
  std::size_t bundles = 0;
  std::size_t dropped_near = 0;         ///< points below min_range
  std::size_t dropped_far = 0;          ///< points above max_range
  std::size_t dropped_out_of_grid = 0;  ///< points beyond the range of keys
};

/// Merges a scan into the map and contradicts nothing: how an initial map is built. New leaves are occupied
/// at once.
ScanSummary add_scan(Octree& octree, const Scan& scan, const Pose& T_map_sensor,
                     const UpdateParameters& parameters);

/// Merges a survey's cloud into the map, trusted as it is: every range, and every leaf as sure as can be.
ScanSummary add_cloud(Octree& octree, const Scan& cloud, const Pose& T_map_cloud,
                      const UpdateParameters& parameters);

/// Brings the map up to date with one aligned scan: condense, trace, apply. `novelty` in (0, 1] weighs the
/// scan's geometry in leaves that exist (see Viewpoint).
///
/// Needs exclusive access to the map. Runs in parallel in the caller's TBB arena; the map that results is
/// byte-identical for any number of threads.
ScanSummary update(Octree& octree, const Scan& scan, const Pose& T_map_sensor,
                   const UpdateParameters& parameters, double novelty = 1);

/// The last step of an update: contradict and confirm. Every leaf that it changes is among the evidence or is
/// hit by a bundle. REQUIRES: `evidence` is what `bundles` say against this map.
void apply(Octree& octree, const BundleGrid& bundles, const Evidence& evidence,
           const UpdateParameters& parameters, double novelty);

ScanSummary summarize(const Scan& scan, const BundleGrid& bundles);

}  // namespace evermap
