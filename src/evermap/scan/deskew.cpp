// SPDX-FileCopyrightText: 2026 the evermap authors
// SPDX-License-Identifier: BSD-3-Clause
#include <algorithm>

#include <evermap/scan/detail/deskew.hpp>

namespace evermap {

Scan deskew(const Scan& scan, const Pose& T_begin_end, double duration) {
  const std::vector<float>& times = scan.time_offset;
  Scan still = scan;
  if (times.empty()) return still;
  const auto [first, last] = std::minmax_element(times.begin(), times.end());
  if (*first == *last) return still;
  const Twist motion = log(T_begin_end);
  double moment = -1;  // points measured at one moment follow each other
  Pose T_end_then;
  for (std::size_t i = 0; i < times.size(); ++i) {
    if (times[i] != moment) {
      moment = times[i];
      const double left = 1 - std::min(moment / duration, 1.0);
      T_end_then = exp(-left * motion);
    }
    still.p_sensor[i] = T_end_then * scan.p_sensor[i];
  }
  still.time_offset.clear();
  return still;
}

}  // namespace evermap
