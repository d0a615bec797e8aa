// SPDX-FileCopyrightText: 2026 the evermap authors
// SPDX-License-Identifier: BSD-3-Clause
#include <algorithm>

#include <evermap/localization/localizer.hpp>

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

Localizer::Localizer(const Pose& T_map_sensor_initial, const LocalizerParameters& parameters)
    : parameters_(parameters), gate_(parameters.gate), T_map_sensor_initial_(T_map_sensor_initial) {}

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
  return (moved.translation - steady.translation).norm() > parameters_.max_jump * slack(time);
}

Localization Localizer::localize(const Octree& map, const Scan& scan, double time,
                                 const std::optional<Pose>& T_odom_sensor, const WriteScan& write) {
  const bool is_later = !last_time_ || time > *last_time_;
  if (!is_later) {
    fail();
    return {predict(time, T_odom_sensor), state_, "is not later than the scan before", {}};
  }
  last_time_ = time;
  const bool jumps = odometry_jumps(time, T_odom_sensor);
  const Pose predicted = predict(time, jumps ? std::nullopt : T_odom_sensor);

  const bool is_search = state_ == TrackingState::kLost;
  const bool motion_is_known = last_ && !is_search && (velocity_ || T_odom_sensor);
  const double wide = motion_is_known ? slack(time) : parameters_.starting_slack;
  const Registration found = register_scan(map, scan, predicted, wide);
  const Pose& expected = is_search ? found.T_map_sensor : predicted;  // a search has its own reach
  std::string objection = gate_.objection(found, expected, wide);
  if (objection.empty() && motion_is_known && !jumps && write) objection = write(found.T_map_sensor);
  if (objection.empty()) {
    gate_.remember(found, predicted, motion_is_known);
    pass({found.T_map_sensor, time, T_odom_sensor}, motion_is_known);
  } else {
    fail();
  }
  if (objection.empty() && jumps) {  // its later steps can be followed again, from here
    state_ = TrackingState::kDegraded;
    objection = "the odometry jumps";
  }
  return {found.converged() ? found.T_map_sensor : predicted, state_, objection, found};
}

Registration Localizer::register_scan(const Octree& map, const Scan& scan, const Pose& predicted,
                                      double slack) const {
  const LocalizerParameters& p = parameters_;
  if (state_ == TrackingState::kLost) {
    return relocate(map, scan, predicted, p.lidar, p.registration, p.relocation);
  }
  if (state_ == TrackingState::kTracking) {
    const auto bundles = bundles_in_sensor_frame(scan, map.grid().edge, p.lidar);
    Registration found = register_bundles(map, bundles, predicted, p.registration);
    if (gate_.objection(found, predicted, slack).empty()) return found;
  }
  return register_coarse_to_fine(map, scan, predicted, p.lidar, p.registration);
}

void Localizer::pass(const Fix& fix, bool motion_is_known) {
  const bool is_search = state_ == TrackingState::kLost;
  velocity_.reset();
  if (last_ && !is_search) {
    velocity_ = log(last_->T_map_sensor.inverse() * fix.T_map_sensor) / (fix.time - last_->time);
  }
  last_ = fix;
  failed_ = 0;
  state_ = motion_is_known ? TrackingState::kTracking : TrackingState::kStarting;
}

void Localizer::fail() {
  ++failed_;
  const bool is_lost = state_ == TrackingState::kLost || failed_ >= parameters_.lost_after;
  state_ = is_lost ? TrackingState::kLost : TrackingState::kDegraded;
}

}  // namespace evermap
