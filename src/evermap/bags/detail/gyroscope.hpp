// SPDX-FileCopyrightText: 2026 the evermap authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <optional>
#include <string>

#include <evermap/bags/detail/messages.hpp>
#include <evermap/bags/detail/transform_buffer.hpp>
#include <evermap/geometry/detail/trajectory.hpp>

namespace evermap {

/// What the rates of a gyroscope add up to, over the last minute.
class Gyroscope {
 public:
  /// Rates that are not later than the one before are left out.
  void add(const TurnRate& rate);

  bool empty() const { return turns_.empty(); }
  double last_time() const { return turns_.last_time(); }  ///< [s] REQUIRES: !empty()
  /// Whether the turn up to a time [s] is known.
  bool reaches(double time) const { return turns_.at(time).has_value(); }
  /// The frame of its axes.
  const std::string& frame() const { return frame_; }
  /// R_inertial_sensor at a time [s]; none where the rates do not reach, or nothing tells how it is mounted.
  std::optional<Eigen::Matrix3d> rotation_of(const std::string& sensor_frame, const TransformBuffer& frames,
                                             double time) const;
  /// Forgets all, as when the clock was set back.
  void forget() { turns_ = {}; }

 private:
  Trajectory turns_;                                     ///< R_inertial_gyroscope
  Eigen::Vector3d last_rate_ = Eigen::Vector3d::Zero();  ///< [rad/s]
  std::string frame_;
};

}  // namespace evermap
