// SPDX-FileCopyrightText: 2026 the evermap authors
// SPDX-License-Identifier: BSD-3-Clause
#include <evermap/io/detail/selected_scans.hpp>

namespace evermap {

std::optional<Scan> SelectedScans::next() {
  while (std::optional<Scan> scan = all_->next()) {
    const double time = scan->time.value_or(static_cast<double>(all_->index()) * selection_.scan_period);
    if (!first_) first_ = time;
    const double since_start = time - *first_ - selection_.start;
    constexpr double kRounding = 1e-6;  // [s]
    if (since_start < -kRounding) continue;
    if (since_start > selection_.duration + kRounding) return std::nullopt;
    if (in_time_++ % selection_.every == 0) return scan;
  }
  return std::nullopt;
}

}  // namespace evermap
