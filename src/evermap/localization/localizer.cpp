// SPDX-FileCopyrightText: 2026 the evermap authors
// SPDX-License-Identifier: BSD-3-Clause
#include <algorithm>

#include <evermap/localization/localizer.hpp>
#include <evermap/localization/perturbation.hpp>
#include <evermap/scan/deskew.hpp>

namespace evermap {
namespace {

constexpr double kMiddle = 1.0;  ///< [m] leaves so wide still tell the faces of a room apart

}  // namespace

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

Localization Localizer::propose(const Octree& map, const Scan& raw, double time,
                                const std::optional<Pose>& T_odom_sensor, Effort effort) {
  Localization found;
  found.time = time;
  found.T_odom_sensor = T_odom_sensor;
  if (last_time_ && time <= *last_time_) {
    found.T_map_sensor = found.T_map_sensor_predicted = predict(time, T_odom_sensor);
    found.reject_reason = RejectReason::kTimeNotLater;
    return found;
  }
  found.odometry_jumps = odometry_jumps(time, T_odom_sensor);
  const auto odometry = found.odometry_jumps ? std::nullopt : T_odom_sensor;
  found.T_map_sensor_predicted = predict(time, odometry);
  found.is_search = state_ == TrackingState::kLost;
  found.motion_is_known = last_ && !found.is_search && (velocity_ || (T_odom_sensor && last_->T_odom_sensor));
  found.slack = found.motion_is_known ? slack(time) : parameters_.gate.starting_slack;
  found.T_begin_end = motion(time, odometry, lidar_.scan_period);
  const Scan scan = undistorted(raw, found.T_begin_end);
  if (!found.is_search) {
    found.registration = register_near(map, scan, found.T_map_sensor_predicted);
    found.hypotheses = {{found.registration}};
    if (found.motion_is_known) undistort(map, raw, found);
  }
  const auto is_doubtful = [&] {
    return gate_.judge(found.hypotheses.front().registration, found.T_map_sensor_predicted, found.slack) !=
           RejectReason::kNone;
  };
  found.is_contested = !found.motion_is_known || effort == Effort::kThorough || is_doubtful();
  if (found.is_contested) {
    found.hypotheses = distinct(register_everywhere(map, scan, found));
    if (found.motion_is_known) undistort(map, raw, found);
    if (!found.motion_is_known && last_scan_) undistort_start(map, raw, found);
    found.is_contested = found.hypotheses.size() > 1 || !found.motion_is_known || is_doubtful();
  }
  if (!found.motion_is_known && !found.is_search) last_scan_ = raw;
  choose(found);
  return found;
}

void Localizer::choose(Localization& found) const {
  if (found.hypotheses.empty()) return;
  const std::size_t best = best_of(found.hypotheses);
  const Hypothesis& winner = found.hypotheses[best];
  found.registration = winner.registration;
  // A search has its own reach.
  const Pose& expected = found.is_search ? winner.registration.T_map_sensor : found.T_map_sensor_predicted;
  found.reject_reason = gate_.judge_winner(winner, expected, found.slack);
  if (found.reject_reason == RejectReason::kNone && has_rival(found.hypotheses, best)) {
    found.reject_reason = RejectReason::kAmbiguous;
  }
  const bool is_blind = !found.T_odom_sensor && (!found.motion_is_known || blind_ >= parameters_.gate.blind);
  if (found.reject_reason == RejectReason::kNone && !winner.registration.converged() && is_blind) {
    found.reject_reason = RejectReason::kUnobservable;
  }
  found.T_map_sensor =
      winner.registration.is_usable() ? winner.registration.T_map_sensor : found.T_map_sensor_predicted;
}

void Localizer::conclude(Localization& found) {
  if (found.reject_reason != RejectReason::kTimeNotLater) last_time_ = found.time;
  if (found.passes()) {
    blind_ = found.registration.converged() ? 0 : blind_ + 1;
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

void Localizer::begin(const Pose& T_map_sensor, double time, const std::optional<Pose>& T_odom_sensor,
                      const std::optional<Twist>& velocity) {
  last_ = {T_map_sensor, time, T_odom_sensor};
  last_time_ = time;
  velocity_ = velocity;
}

Registration Localizer::register_near(const Octree& map, const Scan& scan,
                                      const Pose& T_map_sensor_guess) const {
  const auto bundles = bundles_in_sensor_frame(scan, map.grid().edge, lidar_);
  const Registration fine = register_bundles(map, bundles, T_map_sensor_guess, parameters_.registration);
  if (fine.converged()) return fine;
  const CoarseToFine wider(map, scan, T_map_sensor_guess.translation, lidar_, parameters_.registration,
                           kMiddle);
  const Registration found = wider.from(T_map_sensor_guess);
  const bool is_better = found.is_usable() && (!fine.is_usable() || found.observability.unobservable <
                                                                        fine.observability.unobservable);
  return is_better ? found : fine;
}

Scan Localizer::undistorted(const Scan& raw, const Pose& T_begin_end) const {
  return deskew(raw, T_begin_end, lidar_.scan_period);
}

Pose Localizer::motion_to(const Pose& T_map_sensor, double time) const {
  const Twist since = log(last_->T_map_sensor.inverse() * T_map_sensor);
  return exp(since * lidar_.scan_period / (time - last_->time));
}

std::vector<Registration> Localizer::register_everywhere(const Octree& map, const Scan& scan,
                                                         const Localization& found) const {
  const Pose& predicted = found.T_map_sensor_predicted;
  if (found.is_search) {
    return places(map, scan, predicted, lidar_, parameters_.registration, parameters_.relocation);
  }
  constexpr double kTurn = 0.2;  // [rad] coarse to fine reaches half as far
  constexpr double kStep = 0.8;  // [m] likewise
  const CoarseToFine registration(map, scan, predicted.translation, lidar_, parameters_.registration);
  std::vector<Registration> all{found.registration};
  const auto from = [&](double forward, double yaw) {
    Pose guess = predicted;
    guess.translation += predicted.rotation.col(0) * forward;
    guess.rotation = Eigen::AngleAxisd(yaw, Eigen::Vector3d::UnitZ()) * guess.rotation;
    all.push_back(registration.from(guess, kMiddle));
    all.push_back(registration.from(guess));
  };
  for (const double yaw : {0.0, -kTurn, kTurn}) from(0, yaw);
  if (last_ && !found.motion_is_known) {
    for (const double steps : {-1, 1, 2}) from(kStep * steps, 0);
  }
  return all;
}

void Localizer::undistort(const Octree& map, const Scan& raw, Localization& found) const {
  constexpr int kTries = 3;
  constexpr double kTranslation = 0.01;  // [m] distortion that hardly matters
  constexpr double kRotation = 0.0017;   // [rad] a tenth of a degree
  if (raw.time_offset.empty() || found.hypotheses.empty()) return;
  Registration& best = found.hypotheses[best_of(found.hypotheses)].registration;
  for (int i = 0; i < kTries && best.is_usable(); ++i) {
    const Pose moved = motion_to(best.T_map_sensor, found.time);
    const Twist off = difference(found.T_begin_end, moved);
    if (off.head<3>().norm() < kTranslation && off.tail<3>().norm() < kRotation) return;
    found.T_begin_end = moved;
    best = register_near(map, undistorted(raw, moved), best.T_map_sensor);
  }
}

void Localizer::undistort_start(const Octree& map, const Scan& raw, Localization& found) const {
  constexpr int kTries = 3;
  if (raw.time_offset.empty() || found.hypotheses.empty()) return;
  Registration& best = found.hypotheses[best_of(found.hypotheses)].registration;
  Pose T_before = last_->T_map_sensor;
  for (int i = 0; i < kTries && best.is_usable(); ++i) {
    const Twist since = log(T_before.inverse() * best.T_map_sensor);
    found.T_begin_end = exp(since * lidar_.scan_period / (found.time - last_->time));
    const auto there = [&](const Scan& scan, const Pose& guess) {
      return register_near(map, undistorted(scan, found.T_begin_end), guess);
    };
    const Registration before = there(*last_scan_, T_before);
    best = there(raw, best.T_map_sensor);
    if (before.is_usable()) T_before = before.T_map_sensor;
  }
  found.T_map_sensor_before = T_before;
}

void Localizer::pass(const Localization& found) {
  velocity_.reset();
  if (last_ && !found.is_search) {
    const Pose& before = found.T_map_sensor_before.value_or(last_->T_map_sensor);
    velocity_ = log(before.inverse() * found.T_map_sensor) / (found.time - last_->time);
  }
  if (found.motion_is_known) last_scan_.reset();
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
