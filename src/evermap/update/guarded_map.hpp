// SPDX-FileCopyrightText: 2026 the evermap authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <optional>

#include <evermap/geometry/running_median.hpp>
#include <evermap/update/map_updater.hpp>
#include <evermap/update/probation.hpp>
#include <evermap/update/viewpoint.hpp>

namespace evermap {

/// How a map is protected from scans whose poses nobody vouches for.
struct GuardParameters {
  double max_contradicting = 0.15;  ///< share of a scan's bundles beyond what was usual; a scan that
                                    ///< contradicts more of the map is not where it is thought to be
  double at_first = 0.5;            ///< likewise, before anything is usual: the map may be quite outdated
  std::size_t memory = 51;          ///< [scans] that make what is usual
  std::size_t probation = 20;       ///< [scans] whose changes can be taken back
};

/// A map that localized scans keep up to date. Not thread safe.
class GuardedMap {
 public:
  GuardedMap(Octree octree, const UpdateParameters& parameters, const GuardParameters& guard);

  const Octree& octree() const { return octree_; }

  /// Updates the map, unless the scan contradicts too much of it: then returns none and changes nothing.
  std::optional<ScanSummary> update(const Scan& scan, const Pose& T_map_sensor);

  /// Undoes, bit for bit, what scans on probation changed: their poses turned out to be wrong. Returns how
  /// many scans that were.
  std::size_t take_back();

 private:
  Octree octree_;
  UpdateParameters parameters_;
  GuardParameters guard_;
  Viewpoint viewpoint_;
  Probation probation_;
  RunningMedian contradicting_;
};

}  // namespace evermap
