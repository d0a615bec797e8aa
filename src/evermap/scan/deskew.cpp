// SPDX-FileCopyrightText: 2026 the evermap authors
// SPDX-License-Identifier: BSD-3-Clause
#include <algorithm>
#include <functional>

#include <evermap/scan/detail/deskew.hpp>

namespace evermap {

Pose ScanMotion::pose_at(double fraction, double duration) const {
  if (fraction >= bend) return exp((fraction - 1) * duration * after);
  return exp((bend - 1) * duration * after) * exp((fraction - bend) * duration * before);
}

double fraction_at(float time_offset, double duration) { return std::min(time_offset / duration, 1.0); }

bool has_times(const Scan& scan) {
  const std::vector<float>& times = scan.time_offset;
  return std::adjacent_find(times.begin(), times.end(), std::not_equal_to<>()) != times.end();
}

Scan deskew(const Scan& scan, const ScanMotion& motion, double duration) {
  const std::vector<float>& times = scan.time_offset;
  Scan still = scan;
  if (!has_times(scan)) return still;
  float moment = -1;  // points measured at one moment follow each other
  Pose T_end_then;
  for (std::size_t i = 0; i < times.size(); ++i) {
    if (times[i] != moment) {
      moment = times[i];
      T_end_then = motion.pose_at(fraction_at(moment, duration), duration);
    }
    still.p_sensor[i] = T_end_then * scan.p_sensor[i];
  }
  still.time_offset.clear();
  return still;
}

Scan deskew_between(const Scan& scan, const Pose& T_end_begin) {
  const double duration = *std::max_element(scan.time_offset.begin(), scan.time_offset.end());
  return deskew(scan, ScanMotion::steady(-1 / duration * log(T_end_begin)), duration);
}

}  // namespace evermap
