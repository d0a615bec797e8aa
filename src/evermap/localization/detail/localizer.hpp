// SPDX-FileCopyrightText: 2026 the evermap authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <optional>

#include <evermap/localization/detail/gate.hpp>
#include <evermap/localization/detail/registration.hpp>
#include <evermap/localization/detail/relocation.hpp>
#include <evermap/localization/parameters.hpp>
#include <evermap/localization/tracking_state.hpp>

namespace evermap {

/// A registered scan, and what is to be thought of its pose.
struct Localization {
  Pose T_map_sensor;                               ///< registered when that converged, otherwise predicted
  TrackingState state = TrackingState::kStarting;  ///< after this scan; set by Localizer::conclude
  RejectReason reject_reason = RejectReason::kNone;
  Registration registration;

  double time = 0;                    ///< [s] when the scan ended
  std::optional<Pose> T_odom_sensor;  ///< what odometry said then
  Pose T_map_sensor_predicted;
  bool motion_is_known = false;  ///< the prediction came from odometry or from a known velocity
  bool odometry_jumps = false;   ///< and is therefore not followed

  bool passes() const { return reject_reason == RejectReason::kNone; }
  /// Whether the scan may be written into the map at this pose.
  bool is_writable() const { return passes() && motion_is_known && !odometry_jumps; }
};

/// Follows a sensor through a map, scan by scan: predict, register, gate.
///
/// A scan takes two steps, so that whoever keeps the map has a word in between: `propose` registers it,
/// `conclude` takes it. Predictions start from the last pose that passed the gate, never from one that did
/// not, so that a wrong pose cannot confirm itself. Where everything looks the same, the map cannot tell that
/// odometry slipped from one place to the next; so odometry that jumps is not followed. Not thread safe.
class Localizer {
 public:
  Localizer(const Pose& T_map_sensor_initial, const LidarParameters& lidar,
            const LocalizationParameters& parameters);

  /// Where the sensor should be at `time` [s]: the last pose that passed, moved on by the odometry, or by
  /// constant velocity without.
  Pose predict(double time, const std::optional<Pose>& T_odom_sensor) const;

  /// How the sensor moves, by the same lights, in the `duration` [s] before `time`: what deskew needs.
  Pose motion(double time, const std::optional<Pose>& T_odom_sensor, double duration) const;

  /// Registers a scan, its points all as of `time` [s] (see deskew), and lets the gate judge it. With
  /// odometry, it is to be given for each.
  Localization propose(const Octree& map, const Scan& scan, double time,
                       const std::optional<Pose>& T_odom_sensor) const;

  /// Takes what was proposed; a caller who does not believe it has set its reject reason before. Sets its
  /// state, and its reject reason when the pose is believed but not the odometry.
  void conclude(Localization& found);

  TrackingState state() const { return state_; }

 private:
  /// A pose that passed the gate, and when.
  struct Fix {
    Pose T_map_sensor;
    double time;  ///< [s]
    std::optional<Pose> T_odom_sensor;
  };

  /// How much wider the gate is for a prediction over more than one period. REQUIRES: there was a fix.
  double slack(double time) const;
  bool odometry_jumps(double time, const std::optional<Pose>& T_odom_sensor) const;
  /// What is near is tried first, and what reaches farther when the gate does not like it.
  Registration register_scan(const Octree& map, const Scan& scan, const Pose& predicted, double slack) const;
  void pass(const Localization& found);
  void fail();

  LidarParameters lidar_;
  LocalizationParameters parameters_;
  Gate gate_;
  TrackingState state_ = TrackingState::kStarting;
  Pose T_map_sensor_initial_;
  std::optional<Fix> last_;          ///< none before the first
  std::optional<Twist> velocity_;    ///< [m/s, rad/s] in the sensor's frame, once two fixes tell it
  std::optional<double> last_time_;  ///< [s] of the last scan, passed or not
  int failed_ = 0;                   ///< scans since the last fix
};

}  // namespace evermap
