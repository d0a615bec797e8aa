// SPDX-FileCopyrightText: 2026 the evermap authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstddef>

#include <evermap/geometry/pose.hpp>
#include <evermap/map/octree.hpp>
#include <evermap/scan/detail/ray_bundle.hpp>
#include <evermap/scan/scan.hpp>
#include <evermap/update/detail/evidence.hpp>
#include <evermap/update/detail/rollback.hpp>
#include <evermap/update/detail/surface_regions.hpp>
#include <evermap/update/parameters.hpp>

namespace evermap {

/// What one scan changed in the map.
struct LeafChanges {
  std::size_t occupied = 0;  ///< leaves that became occupied
  std::size_t erased = 0;    ///< occupied leaves that went
};

/// Merges a scan into the map and contradicts nothing: how an initial map is built. New leaves are occupied
/// at once.
LeafChanges add(Octree& octree, const BundleGrid& bundles, const UpdateParameters& parameters);

/// Merges a survey's cloud into the map, trusted as it is: every range, and every leaf as sure as can be.
/// Returns what became of its points.
BundleGrid add_cloud(Octree& octree, const Scan& cloud, const Pose& T_map_cloud, const LidarParameters& lidar,
                     const UpdateParameters& parameters);

/// Brings the map up to date with one scan: trace, apply. `view_weight` in (0, 1] weighs the scan's geometry
/// in leaves that exist (see Viewpoint).
///
/// Needs exclusive access to the map. Runs in parallel in the caller's TBB arena; the map that results is
/// byte-identical for any number of threads.
LeafChanges update(Octree& octree, const BundleGrid& bundles, const UpdateParameters& parameters,
                   double view_weight = 1);

/// The last step of an update: contradict and confirm. What it changes, `rollback` remembers, if given: the
/// leaves of the evidence, those that bundles hit, and those that go with others. `gone` remembers which
/// went, from scan to scan; without it, a surface goes as a whole only with what one scan took. REQUIRES:
/// `evidence` is what `bundles` say against this map.
LeafChanges apply(Octree& octree, const BundleGrid& bundles, const Evidence& evidence,
                  const UpdateParameters& parameters, double view_weight, Rollback* rollback = nullptr,
                  GoneLeaves* gone = nullptr);

}  // namespace evermap
