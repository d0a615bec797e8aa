// SPDX-FileCopyrightText: 2026 the evermap authors
// SPDX-License-Identifier: BSD-3-Clause
#include <evermap/bags/detail/gyroscope.hpp>

namespace evermap {

void Gyroscope::add(const TurnRate& rate) {
  constexpr double kMemory = 60;  // [s]
  frame_ = rate.frame;
  if (turns_.empty()) {
    turns_.add(rate.time, {});
  } else if (rate.time > turns_.last_time()) {
    Twist turn = Twist::Zero();
    turn.tail<3>() = (last_rate_ + rate.rate) / 2 * (rate.time - turns_.last_time());
    turns_.add(rate.time, *turns_.at(turns_.last_time()) * exp(turn));
    turns_.forget_before(rate.time - kMemory);
  } else {
    return;
  }
  last_rate_ = rate.rate;
}

std::optional<Eigen::Matrix3d> Gyroscope::rotation_of(const std::string& sensor_frame,
                                                      const TransformBuffer& frames, double time) const {
  const std::optional<Pose> T_inertial_gyroscope = turns_.at(time);
  const std::optional<Pose> T_gyroscope_sensor =
      frame_ == sensor_frame ? Pose{} : frames.lookup(frame_, sensor_frame, time);
  if (!T_inertial_gyroscope || !T_gyroscope_sensor) return std::nullopt;
  return T_inertial_gyroscope->rotation * T_gyroscope_sensor->rotation;
}

}  // namespace evermap
