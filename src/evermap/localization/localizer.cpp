// SPDX-FileCopyrightText: 2026 the evermap authors
// SPDX-License-Identifier: BSD-3-Clause
#include <algorithm>
#include <utility>

#include <Eigen/Geometry>

#include <evermap/geometry/detail/degree.hpp>
#include <evermap/localization/detail/localizer.hpp>
#include <evermap/localization/detail/motion_fit.hpp>
#include <evermap/localization/detail/perturbation.hpp>
#include <evermap/scan/detail/deskew.hpp>

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

bool Localization::is_precise() const {
  constexpr double kShift = 0.05;          // [m]
  constexpr double kTurn = 0.5 * kDegree;  // [rad]
  const WeakestDirection weakest = weakest_direction(registration.covariance);
  return weakest.sigma < (weakest.is_rotation ? kTurn : kShift);
}

Localizer::Localizer(const Pose& T_map_sensor_initial, const LidarParameters& lidar,
                     const LocalizationParameters& parameters)
    : lidar_(lidar),
      parameters_(parameters),
      gate_(parameters.gate),
      T_map_sensor_initial_(T_map_sensor_initial) {}

Pose Localizer::predict(double time, const EgoMotion& ego) const {
  if (!last_) return T_map_sensor_initial_ * moved_by_odometry(first_ego_, ego).value_or(Pose{});
  if (const auto moved = moved_by_odometry(last_->ego, ego)) return last_->T_map_sensor * *moved;
  Twist moved = Twist::Zero();
  if (!is_lost()) moved = velocity_.value_or(last_->velocity) * (time - last_->time);
  if (const auto turn = turn_by_gyroscope(ego))
    moved.tail<3>() = *turn - gyroscope_bias_ * (time - last_->time);
  return last_->T_map_sensor * exp(moved);
}

std::optional<Eigen::Vector3d> Localizer::turn_by_gyroscope(const EgoMotion& ego) const {
  if (!last_ || !ego.R_inertial_sensor || !last_->ego.R_inertial_sensor) return std::nullopt;
  return log(Pose{last_->ego.R_inertial_sensor->transpose() * *ego.R_inertial_sensor}).tail<3>();
}

void Localizer::learn_bias(const Localization& found) {
  constexpr double kMemory = 100;  // [scans]
  const std::optional<Eigen::Vector3d> turn = turn_by_gyroscope(found.ego);
  if (!turn || is_lost() || !found.motion_is_known || found.registration.unobservable > 0) return;
  const Eigen::Vector3d turned = log(last_->T_map_sensor.inverse() * found.T_map_sensor).tail<3>();
  biases_ = std::min(biases_ + 1, kMemory);
  gyroscope_bias_ += ((*turn - turned) / (found.time - last_->time) - gyroscope_bias_) / biases_;
}

void Localizer::begin(const Pose& T_map_sensor, double time, const EgoMotion& ego,
                      const std::optional<Twist>& velocity) {
  last_ = {T_map_sensor, within(0, 0), velocity.value_or(Twist::Zero()), time, ego};
  last_scan_ = {time, ego};
  velocity_ = velocity;
  is_own_map_ = true;
  // What settling is for, old changes, is not in such a map; odometry on a VLP-16 drifts by 1.4 % without it
  // and by 1.8 with it.
  parameters_.registration.settling_width = 0;
}

Twist Localizer::velocity_to(const Pose& T_map_sensor, double time) const {
  return log(last_->T_map_sensor.inverse() * T_map_sensor) / (time - last_->time);
}

std::optional<Twist> Localizer::velocity_by_odometry(double time, const EgoMotion& ego) const {
  const auto moved = last_scan_ ? moved_by_odometry(last_scan_->ego, ego) : std::nullopt;
  if (!moved) return std::nullopt;
  return log(*moved) / (time - last_scan_->time);
}

Twist Localizer::velocity_between_middles(const Pose& T_map_sensor, const Twist& velocity,
                                          const Localization& found) const {
  const double half = found.is_deskewed ? lidar_.scan_period / 2 : 0;
  const Pose T_map_middle_last = last_->T_map_sensor * exp(-half * last_->velocity);
  const Pose T_map_middle = T_map_sensor * exp(-half * velocity);
  return log(T_map_middle_last.inverse() * T_map_middle) / (found.time - last_->time);
}

Scan Localizer::undistorted(const Scan& raw, const Twist& velocity) const {
  return deskew(raw, ScanMotion::steady(velocity), lidar_.scan_period);
}

double Localizer::slack(double time) const {
  constexpr double kPeriod = 0.1;  // [s] that the gate's distances are for
  return std::max(1.0, std::abs(time - last_->time) / kPeriod);
}

bool Localizer::has_odometry(const Localization& found) const {
  return last_ && moved_by_odometry(last_->ego, found.ego) && !found.odometry_jumps;
}

double Localizer::slack(const Localization& found) const {
  if (!found.motion_is_known) return parameters_.gate.starting_slack;
  return has_odometry(found) ? 1 : slack(found.time);  // it drifts with the way, not with time
}

Twist Localizer::odometry_off_steady(double time, const EgoMotion& ego) const {
  const auto moved = velocity_ ? moved_by_odometry(last_->ego, ego) : std::nullopt;
  if (!moved) return Twist::Zero();
  const Pose steady = exp(*velocity_ * (time - last_->time));
  return difference(steady, *moved) / slack(time);
}

bool Localizer::odometry_jumps(double time, const EgoMotion& ego) const {
  const Twist off = odometry_off_steady(time, ego);
  return off.head<3>().norm() > parameters_.gate.max_jump ||
         off.tail<3>().norm() > parameters_.gate.max_turn_jump;
}

Localization Localizer::propose(const Octree& map, const Scan& raw, double time, const EgoMotion& ego,
                                const Contradicting& contradicting, Effort effort) const {
  if (!last_scan_ || time > last_scan_->time) {
    return locate(map, raw, time, ego, contradicting, effort);
  }
  Localization found;
  found.time = time;
  found.ego = ego;
  found.T_map_sensor = found.T_map_sensor_predicted = predict(time, ego);
  found.reject_reason = RejectReason::kTimeNotLater;
  return found;
}

Localization Localizer::propose_earlier(const Octree& map, const Scan& raw, double time, const EgoMotion& ego,
                                        const Contradicting& contradicting, Effort effort) const {
  Localization found = locate(map, raw, time, ego, contradicting, effort);
  if (found.passes() && found.odometry_jumps) found.reject_reason = RejectReason::kOdometryJumps;
  found.state = found.passes() ? TrackingState::kTracking : TrackingState::kDegraded;
  return found;
}

Localization Localizer::locate(const Octree& map, const Scan& raw, double time, const EgoMotion& ego,
                               const Contradicting& contradicting, Effort effort) const {
  Localization found;
  found.time = time;
  found.ego = ego;
  found.odometry_jumps = odometry_jumps(time, ego);
  found.T_map_sensor_predicted =
      predict(time, found.odometry_jumps ? EgoMotion{{}, ego.R_inertial_sensor} : ego);
  found.motion_is_known = last_ && !is_lost() && (velocity_ || has_odometry(found));
  if (last_) {
    found.velocity = velocity_to(found.T_map_sensor_predicted, time);
  } else if (const auto velocity = velocity_by_odometry(time, ego)) {
    found.velocity = *velocity;
  }
  found.scan = undistorted(raw, found.velocity);
  found.is_deskewed = has_times(raw);
  const PoseEstimate predicted{found.T_map_sensor_predicted, uncertainty(found, time)};
  if (found.motion_is_known && effort == Effort::kUsual) {
    Hypothesis near{{}, std::move(found.scan), ScanMotion::steady(found.velocity)};
    near.registration = register_near(map, near.scan, predicted);
    if (found.is_deskewed) {
      refit(map, raw, predicted.covariance, found, near);
      const bool is_doubtful = gate_.knows_what_is_usual() && !gate_.is_usual(near.registration);
      if (is_doubtful) try_turns(map, raw, predicted.covariance, found, near);
    }
    if (is_starting()) look_beside(map, predicted.covariance, near);
    take(std::move(near), found);
    found.reject_reason = gate_.judge(found.registration, found.T_map_sensor_predicted, slack(found));
  }
  if (!found.motion_is_known || effort == Effort::kThorough || !found.passes()) {
    consider_places(map, raw, predicted, contradicting, found);
  }
  if (found.passes() && is_vague(found)) found.reject_reason = RejectReason::kUnobservable;
  const bool converged = found.registration.converged();
  found.T_map_sensor = converged ? found.registration.T_map_sensor : found.T_map_sensor_predicted;
  return found;
}

bool Localizer::is_vague(const Localization& found) const {
  const WeakestDirection weakest = weakest_direction(found.registration.covariance);
  if (found.ego.T_odom_sensor && !found.odometry_jumps) {
    return weakest.sigma > (weakest.is_rotation ? 10 * kDegree : 1);
  }
  return weakest.sigma > (weakest.is_rotation ? kDegree : 0.1);  // of a velocity that may change any time
}

void Localizer::take(Hypothesis&& place, Localization& found) const {
  found.registration = place.registration;
  found.scan = std::move(place.scan);
  found.velocity = place.motion.after;
  if (!last_) return;
  const bool is_bent = place.motion.bend > 0;
  found.motion = is_bent ? found.velocity
                         : velocity_between_middles(place.registration.T_map_sensor, found.velocity, found);
}

void Localizer::consider_places(const Octree& map, const Scan& raw, const PoseEstimate& predicted,
                                const Contradicting& contradicting, Localization& found) const {
  std::vector<Hypothesis> all = is_lost() ? search(map, found) : guess_around(map, raw, predicted, found);
  if (found.is_deskewed && last_ && !is_lost()) {
    for (Hypothesis& place : all) {
      if (found.motion_is_known)
        refit(map, raw, predicted.covariance, found, place);
      else
        undistort_again(map, raw, predicted.covariance, found, place);
    }
  }
  const bool is_start = !found.motion_is_known || is_starting();
  if (is_start) look_beside(map, predicted.covariance, all[best_of(all)]);
  all = distinct(std::move(all), lidar_.scan_period);
  if (contradicting) {
    for (Hypothesis& place : all) {
      place.contradicting_fraction = contradicting(place.scan, place.registration.T_map_sensor);
    }
  }
  const std::size_t best = best_of(all);
  Hypothesis& winner = all[best];
  // A search has its own reach.
  const Pose& expected = is_lost() ? winner.registration.T_map_sensor : found.T_map_sensor_predicted;
  found.reject_reason = gate_.judge_best(all, best, expected, slack(found));
  // A floor fits anywhere on a floor. In a map that was there before, a place is found by more than that; not
  // by its rays, which contradict an outdated map, too.
  constexpr double kLeastScore = 0.35;
  if (found.passes() && is_start && !is_own_map_ && winner.registration.score() < kLeastScore)
    found.reject_reason = RejectReason::kTooFewInliers;
  constexpr double kAsGood = 0.95;
  if (found.passes() && winner.registration.explained_fraction() < kAsGood * tied_)
    found.reject_reason = RejectReason::kAmbiguous;
  if (contradicting) found.contradicting_fraction = winner.contradicting_fraction;
  const bool was_measured = found.motion_is_known && winner.motion.after != found.velocity;
  take(std::move(winner), found);
  if (was_measured) found.motion = found.velocity;
}

void Localizer::look_beside(const Octree& map, const Matrix6& covariance, Hypothesis& place) const {
  const PoseEstimate found{place.registration.T_map_sensor, covariance};
  for (const Registration& beside : places_beside(map, place.scan, found, lidar_, parameters_.registration)) {
    // What nothing tells would be as it was displaced here, and not as it was predicted.
    if (beside.converged() && beside.unobservable == 0 && beside.score() > place.registration.score())
      place.registration = beside;
  }
}

Hypothesis Localizer::moving(const Octree& map, const Scan& raw, const ScanMotion& motion,
                             const PoseEstimate& guess) const {
  Hypothesis place{{}, deskew(raw, motion, lidar_.scan_period), motion};
  place.registration = register_near(map, place.scan, guess);
  return place;
}

void Localizer::undistort_again(const Octree& map, const Scan& raw, const Matrix6& covariance,
                                const Localization& found, Hypothesis& place) const {
  constexpr int kTries = 2;
  constexpr double kTranslation = 0.03;  // [m] within a scan, which hardly matters
  constexpr double kRotation = 0.005;    // [rad]
  for (int i = 0; i < kTries && place.registration.converged(); ++i) {
    const Pose& T_map_sensor = place.registration.T_map_sensor;
    const Twist moved = velocity_between_middles(T_map_sensor, place.motion.after, found);
    const Twist off = lidar_.scan_period * (moved - place.motion.after);
    if (off.head<3>().norm() < kTranslation && off.tail<3>().norm() < kRotation) return;
    Hypothesis again = moving(map, raw, ScanMotion::steady(moved), {T_map_sensor * exp(off / 2), covariance});
    if (again.score() <= place.score()) return;
    place = std::move(again);
  }
}

void Localizer::refit(const Octree& map, const Scan& raw, const Matrix6& covariance,
                      const Localization& found, Hypothesis& place) const {
  constexpr int kTries = 3;
  const bool is_steady = place.motion.bend == 0;  // only then the scan's middle tells its velocity
  if (is_steady) undistort_again(map, raw, covariance, found, place);
  MotionPrior prior{begin_of(found, map.grid().edge), covariance, std::nullopt};
  if (has_odometry(found)) prior.end = {found.T_map_sensor_predicted, covariance};
  bool gains = true;
  for (int i = 0; gains && i < kTries && place.registration.converged(); ++i) {
    gains = false;
    const auto better = fit_motion(map, raw, place.scan, {place.motion, place.registration.T_map_sensor},
                                   prior, lidar_, parameters_.registration);
    for (const MovingPose& moved : better) {
      Hypothesis again = moving(map, raw, moved.motion, {moved.T_map_sensor, covariance});
      if (again.score() <= place.score()) continue;
      place = std::move(again);
      gains = true;
    }
  }
}

void Localizer::try_turns(const Octree& map, const Scan& raw, const Matrix6& covariance,
                          const Localization& found, Hypothesis& place) const {
  const PoseEstimate begin = begin_of(found, map.grid().edge);
  const MovingPose guess = best_turn(map, raw, begin.T_map_sensor, velocity_.value_or(found.velocity), lidar_,
                                     parameters_.registration);
  Hypothesis turned =
      moving(map, raw, guess.motion, {guess.T_map_sensor, covariance + within(0.1, 3 * kDegree)});
  refit(map, raw, covariance, found, turned);
  const double better = place.score() + gate_.least_difference();
  if (turned.registration.converged() && turned.score() > better) place = std::move(turned);
}

PoseEstimate Localizer::begin_of(const Localization& found, double edge) const {
  const double unseen = found.time - lidar_.scan_period - last_->time;  // [s] between the scans
  const double shift = std::max(0.01, edge / 20);  // [m] a fix may be off and not know it
  constexpr double kSpeed = 1;                     // [m/s] that may have changed since
  constexpr double kLever = 10;                    // [m]
  const double off = shift + kSpeed * std::abs(unseen);
  const Pose T_map_begin = last_->T_map_sensor * exp(unseen * last_->velocity);
  return {T_map_begin, last_->covariance + within(off, off / kLever)};
}

void Localizer::conclude(Localization& found) {
  if (!last_scan_) first_ego_ = found.ego;
  if (found.reject_reason != RejectReason::kTimeNotLater) last_scan_ = {found.time, found.ego};
  if (found.passes()) {
    gate_.remember(found.registration, found.T_map_sensor_predicted, found.motion_is_known);
    if (found.contradicting_fraction) gate_.remember_contradicting(*found.contradicting_fraction);
    pass(found);
    if (found.odometry_jumps) {  // its later steps can be followed again, from here
      state_ = TrackingState::kDegraded;
      found.reject_reason = RejectReason::kOdometryJumps;
    }
  } else {
    if (found.reject_reason == RejectReason::kAmbiguous)
      tied_ = std::max(tied_, found.registration.explained_fraction());
    fail();
  }
  found.state = state_;
}

Matrix6 Localizer::uncertainty(const Localization& found, double time) const {
  if (!last_) return within(0.5, 5 * kDegree);
  if (has_odometry(found)) {
    constexpr double kDrift = 0.02;
    constexpr double kUsual = 0.05;  // [m] by which vehicles leave constant velocity in 0.1 s; else
    constexpr double kUsualTurn = 3 * kDegree;  // their wheels may have slipped
    const Twist moved = log(last_->T_map_sensor.inverse() * found.T_map_sensor_predicted);
    const Twist off = odometry_off_steady(time, found.ego);
    const double slipped = std::max(0.0, off.head<3>().norm() - kUsual);
    const double turned = std::max(0.0, off.tail<3>().norm() - kUsualTurn);
    return last_->covariance + within(0.005 + kDrift * moved.head<3>().norm() + slipped,
                                      0.1 * kDegree + kDrift * moved.tail<3>().norm() + turned);
  }
  if (!found.motion_is_known) return last_->covariance + within(1, 5 * kDegree);
  constexpr double kGyroscope = 0.3;
  const double turn = turn_by_gyroscope(found.ego) ? kGyroscope : 1;  // [degrees]
  return last_->covariance + within(0.05 * slack(time), turn * kDegree * slack(time));
}

Registration Localizer::register_near(const Octree& map, const Scan& scan,
                                      const PoseEstimate& predicted) const {
  const auto bundles = bundles_in_sensor_frame(scan, map.grid().edge, lidar_);
  Registration fine = register_bundles(map, bundles, predicted, parameters_.registration);
  if (fine.converged() && fine.unobservable == 0) return fine;
  Registration wide = register_coarse_to_fine(map, scan, predicted, lidar_, parameters_.registration);
  return fine.converged() && wide.unobservable >= fine.unobservable ? fine : wide;
}

std::vector<Hypothesis> Localizer::guess_around(const Octree& map, const Scan& raw,
                                                const PoseEstimate& predicted,
                                                const Localization& found) const {
  constexpr double kTurn = 0.15;  // [rad] coarse to fine reaches as far, and the distortion is small
  constexpr double kStep = 0.8;   // [m] likewise
  CoarseToFine registration(map, found.scan, predicted.T_map_sensor.translation, lidar_,
                            parameters_.registration);
  std::vector<Hypothesis> places;
  for (std::size_t views = 0; views <= registration.views(); ++views) {
    places.push_back({registration.from(predicted, views), found.scan, ScanMotion::steady(found.velocity)});
  }
  const auto try_from = [&](double forward, double yaw, double speed) {
    PoseEstimate guess = predicted;
    guess.T_map_sensor.translation += guess.T_map_sensor.rotation.col(0) * forward;
    guess.T_map_sensor.rotation =
        Eigen::AngleAxisd(yaw, Eigen::Vector3d::UnitZ()) * guess.T_map_sensor.rotation;
    Hypothesis place{{}, found.scan, ScanMotion::steady(found.velocity)};
    if (found.is_deskewed) {
      Twist velocity = found.motion_is_known ? velocity_to(guess.T_map_sensor, found.time) : found.velocity;
      velocity.x() += speed;
      place = {{}, undistorted(raw, velocity), ScanMotion::steady(velocity)};
      registration.set_scan(place.scan);
    }
    place.registration = registration.from(guess, registration.views());
    // What nothing tells would be as it was displaced here, and not as it was predicted.
    if (place.registration.unobservable == 0) places.push_back(std::move(place));
  };
  for (const double turns : {-1, 1, -2, 2}) try_from(0, kTurn * turns, 0);
  if (last_ && !found.motion_is_known) {
    for (const double steps : {-1, 1, 2}) try_from(kStep * steps, 0, 0);
  }
  if (!last_ && found.is_deskewed && !velocity_by_odometry(found.time, found.ego)) {
    for (const double speed : {-3, 3, 6, 9, 12, 15}) try_from(0, 0, speed);
  }
  return places;
}

std::vector<Hypothesis> Localizer::search(const Octree& map, const Localization& found) const {
  std::vector<Hypothesis> all;
  for (const Registration& place : places(map, found.scan, found.T_map_sensor_predicted, lidar_,
                                          parameters_.registration, parameters_.relocation)) {
    all.push_back({place, found.scan, ScanMotion::steady(found.velocity)});
  }
  return all;
}

void Localizer::pass(const Localization& found) {
  learn_bias(found);
  const std::optional<Twist> before = std::exchange(velocity_, std::nullopt);
  if (last_ && !is_lost()) {
    // What scans without a word about some direction left open was not driven since the last alone.
    const double share = 1.0 / (1 + unobservable_);
    velocity_ = before ? Twist(*before + share * (found.motion - *before)) : found.motion;
  }
  last_ = {found.T_map_sensor, found.registration.covariance, found.velocity, found.time, found.ego};
  failed_ = 0;
  tied_ = 0;
  unobservable_ = found.registration.unobservable > 0 ? unobservable_ + 1 : 0;
  state_ = found.motion_is_known ? TrackingState::kTracking : TrackingState::kStarting;
}

void Localizer::fail() {
  ++failed_;
  state_ =
      is_lost() || failed_ >= parameters_.gate.lost_after ? TrackingState::kLost : TrackingState::kDegraded;
}

}  // namespace evermap
