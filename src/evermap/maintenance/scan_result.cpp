// SPDX-FileCopyrightText: 2026 the evermap authors
// SPDX-License-Identifier: BSD-3-Clause
#include <evermap/maintenance/scan_result.hpp>

namespace evermap {

PointCounts::PointCounts(const Scan& scan, const BundleGrid& bundles)
    : total(scan.p_sensor.size() + scan.dropped_not_finite + scan.dropped_at_origin),
      used(scan.p_sensor.size() - bundles.dropped_near - bundles.dropped_far - bundles.dropped_out_of_grid),
      not_finite(scan.dropped_not_finite),
      at_origin(scan.dropped_at_origin),
      near(bundles.dropped_near),
      far(bundles.dropped_far),
      out_of_grid(bundles.dropped_out_of_grid) {}

PointCounts& PointCounts::operator+=(const PointCounts& other) {
  for (const auto count :
       {&PointCounts::total, &PointCounts::used, &PointCounts::not_finite, &PointCounts::at_origin,
        &PointCounts::near, &PointCounts::far, &PointCounts::out_of_grid}) {
    this->*count += other.*count;
  }
  return *this;
}

}  // namespace evermap
