// SPDX-FileCopyrightText: 2026 the evermap authors
// SPDX-License-Identifier: BSD-3-Clause
#include <algorithm>
#include <utility>

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

void append(std::vector<ScanResult>& run, ScanResult result) {
  for (ScanResult& confirmed : result.confirmed) {
    const auto before = std::find_if(run.rbegin(), run.rend(),
                                     [&](const ScanResult& scan) { return scan.time == confirmed.time; });
    if (before != run.rend()) *before = std::move(confirmed);
  }
  result.confirmed.clear();
  run.push_back(std::move(result));
}

}  // namespace evermap
