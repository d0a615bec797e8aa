// SPDX-FileCopyrightText: 2026 the evermap authors
// SPDX-License-Identifier: BSD-3-Clause
#include <algorithm>

#include <evermap/localization/detail/localizer.hpp>

namespace evermap {

std::string_view to_string(TrackingState state) {
  switch (state) {
    case TrackingState::kStarting:
      return "starting";
    case TrackingState::kTracking:
      return "tracking";
    case TrackingState::kDegraded:
      return "degraded";
    case TrackingState::kLost:
      break;
  }
  return "lost";
}

Localizer::Localizer(const Pose& T_map_sensor_initial, const LidarParameters& lidar,
                     const LocalizationParameters& parameters)
    : lidar_(lidar),
      parameters_(parameters),
      gate_(parameters.gate),
      T_map_sensor_initial_(T_map_sensor_initial) {}

Pose Localizer::predict(double time, const std::optional<Pose>& T_odom_sensor) const {
  if (!last_) return T_map_sensor_initial_;
  if (T_odom_sensor && last_->T_odom_sensor) {
    return last_->T_map_sensor * (last_->T_odom_sensor->inverse() * *T_odom_sensor);
  }
  const bool moves_on = velocity_ && state_ != TrackingState::kLost;
  return moves_on ? last_->T_map_sensor * exp(*velocity_ * (time - last_->time)) : last_->T_map_sensor;
}

Pose Localizer::motion(double time, const std::optional<Pose>& T_odom_sensor, double duration) const {
  if (!last_ || time <= last_->time) return {};
  const Twist since = log(last_->T_map_sensor.inverse() * predict(time, T_odom_sensor));
  return exp(since * duration / (time - last_->time));
}

double Localizer::slack(double time) const {
  constexpr double kPeriod = 0.1;  // [s] that the gate's distances are for
  return std::max(1.0, (time - last_->time) / kPeriod);
}

bool Localizer::odometry_jumps(double time, const std::optional<Pose>& T_odom_sensor) const {
  if (!velocity_ || !last_->T_odom_sensor || !T_odom_sensor) return false;
  const Pose moved = last_->T_odom_sensor->inverse() * *T_odom_sensor;
  const Pose steady = exp(*velocity_ * (time - last_->time));
  return (moved.translation - steady.translation).norm() > parameters_.gate.max_jump * slack(time);
}

Localization Localizer::propose(const Octree& map, const Scan& scan, double time,
                                const std::optional<Pose>& T_odom_sensor) const {
  Localization found;
  found.time = time;
  found.T_odom_sensor = T_odom_sensor;
  if (last_time_ && time <= *last_time_) {
    found.T_map_sensor = found.T_map_sensor_predicted = predict(time, T_odom_sensor);
    found.reject_reason = RejectReason::kTimeNotLater;
    return found;
  }
  found.odometry_jumps = odometry_jumps(time, T_odom_sensor);
  found.T_map_sensor_predicted = predict(time, found.odometry_jumps ? std::nullopt : T_odom_sensor);
  const bool is_search = state_ == TrackingState::kLost;
  found.motion_is_known = last_ && !is_search && (velocity_ || T_odom_sensor);
  const double wide = found.motion_is_known ? slack(time) : parameters_.gate.starting_slack;
  found.registration = register_scan(map, scan, found.T_map_sensor_predicted, wide);
  const bool converged = found.registration.converged();
  found.T_map_sensor = converged ? found.registration.T_map_sensor : found.T_map_sensor_predicted;
  // A search has its own reach.
  const Pose& expected = is_search ? found.registration.T_map_sensor : found.T_map_sensor_predicted;
  found.reject_reason = gate_.judge(found.registration, expected, wide);
  return found;
}

void Localizer::conclude(Localization& found) {
  if (found.reject_reason != RejectReason::kTimeNotLater) last_time_ = found.time;
  if (found.passes()) {
    gate_.remember(found.registration, found.T_map_sensor_predicted, found.motion_is_known);
    pass(found);
    if (found.odometry_jumps) {  // its later steps can be followed again, from here
      state_ = TrackingState::kDegraded;
      found.reject_reason = RejectReason::kOdometryJumps;
    }
  } else {
    fail();
  }
  found.state = state_;
}

Registration Localizer::register_scan(const Octree& map, const Scan& scan, const Pose& predicted,
                                      double slack) const {
  const LocalizationParameters& p = parameters_;
  if (state_ == TrackingState::kLost) {
    return relocate(map, scan, predicted, lidar_, p.registration, p.relocation);
  }
  if (state_ == TrackingState::kTracking) {
    const auto bundles = bundles_in_sensor_frame(scan, map.grid().edge, lidar_);
    Registration found = register_bundles(map, bundles, predicted, p.registration);
    if (gate_.judge(found, predicted, slack) == RejectReason::kNone) return found;
  }
  return register_coarse_to_fine(map, scan, predicted, lidar_, p.registration);
}

void Localizer::pass(const Localization& found) {
  const bool is_search = state_ == TrackingState::kLost;
  velocity_.reset();
  if (last_ && !is_search) {
    velocity_ = log(last_->T_map_sensor.inverse() * found.T_map_sensor) / (found.time - last_->time);
  }
  last_ = {found.T_map_sensor, found.time, found.T_odom_sensor};
  failed_ = 0;
  state_ = found.motion_is_known ? TrackingState::kTracking : TrackingState::kStarting;
}

void Localizer::fail() {
  ++failed_;
  const bool is_lost = state_ == TrackingState::kLost || failed_ >= parameters_.gate.lost_after;
  state_ = is_lost ? TrackingState::kLost : TrackingState::kDegraded;
}

}  // namespace evermap
