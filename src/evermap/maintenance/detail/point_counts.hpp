// SPDX-FileCopyrightText: 2026 the evermap authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <evermap/maintenance/scan_result.hpp>
#include <evermap/scan/detail/ray_bundle.hpp>

namespace evermap {

/// What became of a scan's points when it was condensed into `bundles`.
inline ScanResult::PointCounts count_points(const Scan& scan, const BundleGrid& bundles) {
  const std::size_t given = scan.p_sensor.size();
  return {given + scan.dropped_not_finite + scan.dropped_at_origin,
          given - bundles.dropped_near - bundles.dropped_on_vehicle - bundles.dropped_far -
              bundles.dropped_out_of_grid,
          scan.dropped_not_finite,
          scan.dropped_at_origin,
          bundles.dropped_near,
          bundles.dropped_on_vehicle,
          bundles.dropped_far,
          bundles.dropped_out_of_grid};
}

}  // namespace evermap
