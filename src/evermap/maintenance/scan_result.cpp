// SPDX-FileCopyrightText: 2026 the evermap authors
// SPDX-License-Identifier: BSD-3-Clause
#include <evermap/maintenance/scan_result.hpp>

namespace evermap {

ScanResult::PointCounts& ScanResult::PointCounts::operator+=(const PointCounts& other) {
  for (const auto count :
       {&PointCounts::total, &PointCounts::used, &PointCounts::not_finite, &PointCounts::at_origin,
        &PointCounts::near, &PointCounts::on_vehicle, &PointCounts::far, &PointCounts::out_of_grid}) {
    this->*count += other.*count;
  }
  return *this;
}

}  // namespace evermap
