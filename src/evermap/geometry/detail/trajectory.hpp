// SPDX-FileCopyrightText: 2026 the evermap authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <deque>
#include <optional>
#include <utility>

#include <evermap/geometry/pose.hpp>

namespace evermap {

/// Where a frame was over time: poses at moments, and between two of them on the screw that joins them.
class Trajectory {
 public:
  /// Adds a pose later than all others; one that is not is left out.
  void add(double time, const Pose& pose);
  /// Drops what is older than `time` [s], except for the pose just before it.
  void forget_before(double time);

  bool empty() const { return poses_.empty(); }
  double first_time() const { return poses_.front().first; }  ///< [s] REQUIRES: !empty()
  double last_time() const { return poses_.back().first; }    ///< [s] REQUIRES: !empty()
  /// None before the first and after the last pose, and in a gap of more than 2.5 s.
  std::optional<Pose> at(double time) const;

 private:
  std::deque<std::pair<double, Pose>> poses_;  ///< by time
};

}  // namespace evermap
