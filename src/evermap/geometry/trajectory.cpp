// SPDX-FileCopyrightText: 2026 the evermap authors
// SPDX-License-Identifier: BSD-3-Clause
#include <algorithm>

#include <evermap/geometry/detail/trajectory.hpp>

namespace evermap {
namespace {

constexpr double kLongestGap = 2.5;     // [s] beyond which a vehicle may have been anywhere between
constexpr double kTimeRounding = 1e-6;  // [s] times in files have six decimals

}  // namespace

void Trajectory::add(double time, const Pose& pose) {
  if (empty() || time > last_time()) poses_.emplace_back(time, pose);
}

void Trajectory::forget_before(double time) {
  while (poses_.size() > 1 && poses_[1].first <= time) poses_.pop_front();
}

std::optional<Pose> Trajectory::at(double time) const {
  const auto after = std::lower_bound(poses_.begin(), poses_.end(), time - kTimeRounding,
                                      [](const auto& pose, double t) { return pose.first < t; });
  if (after == poses_.end()) return std::nullopt;
  if (after->first <= time + kTimeRounding) return after->second;
  if (after == poses_.begin()) return std::nullopt;
  const auto before = std::prev(after);
  const double gap = after->first - before->first;
  if (gap > kLongestGap) return std::nullopt;
  const Twist motion = log(before->second.inverse() * after->second);
  return before->second * exp((time - before->first) / gap * motion);
}

}  // namespace evermap
