// SPDX-FileCopyrightText: 2026 the evermap authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <functional>
#include <optional>
#include <string>
#include <string_view>

#include <evermap/localization/gate.hpp>
#include <evermap/localization/registration.hpp>
#include <evermap/localization/relocation.hpp>

namespace evermap {

/// How well the robot knows where it is.
enum class TrackingState {
  kStarting,  ///< poses fit the map, but its motion is not known yet
  kTracking,  ///< the pose is believed; nothing may be written into the map in any other state
  kDegraded,  ///< the last scans did not pass the gate
  kLost,      ///< too many of them did not; it searches around where it was last
};
std::string_view to_string(TrackingState state);

struct LocalizerParameters {
  LidarParameters lidar;
  RegistrationParameters registration;
  GateParameters gate;
  RelocationParameters relocation;
  double starting_slack = 5;  ///< times the gate's distances, while the motion is not known
  double max_jump = 0.6;      ///< [m] by which odometry may leave constant velocity in 0.1 s: no
                              ///< vehicle can, so that its wheels have slipped
  int lost_after = 5;         ///< scans in a row that did not pass the gate
};

/// A scan's pose, and what is to be thought of it.
struct Localization {
  Pose T_map_sensor;  ///< registered when that converged, otherwise predicted
  TrackingState state = TrackingState::kStarting;
  std::string objection;  ///< why the scan did not pass the gate; empty when it did
  Registration registration;
};

/// Writes the scan, at this pose, into the map; says why it did not, and nothing when it did.
using WriteScan = std::function<std::string(const Pose& T_map_sensor)>;

/// Follows a sensor through a map, scan by scan: predict, register, gate.
///
/// Predictions start from the last pose that passed the gate, never from one that did not, so that a wrong
/// pose cannot confirm itself. Where everything looks the same, the map cannot tell that odometry slipped
/// from one place to the next; so odometry that jumps is not followed. Not thread safe.
class Localizer {
 public:
  Localizer(const Pose& T_map_sensor_initial, const LocalizerParameters& parameters);

  /// Where the sensor should be at `time` [s]: the last pose that passed, moved on by the odometry, or by
  /// constant velocity without.
  Pose predict(double time, const std::optional<Pose>& T_odom_sensor) const;

  /// How the sensor moves, by the same lights, in the `duration` [s] before `time`: what deskew needs.
  Pose motion(double time, const std::optional<Pose>& T_odom_sensor, double duration) const;

  /// Takes a scan, its points all as of `time` [s] (see deskew). With odometry, it is to be given for each.
  /// `write`, when given, is called with the poses that are believed, and with no others.
  Localization localize(const Octree& map, const Scan& scan, double time,
                        const std::optional<Pose>& T_odom_sensor, const WriteScan& write = {});

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
  void pass(const Fix& fix, bool motion_is_known);
  void fail();

  LocalizerParameters parameters_;
  Gate gate_;
  TrackingState state_ = TrackingState::kStarting;
  Pose T_map_sensor_initial_;
  std::optional<Fix> last_;          ///< none before the first
  std::optional<Twist> velocity_;    ///< [m/s, rad/s] in the sensor's frame, once two fixes tell it
  std::optional<double> last_time_;  ///< [s] of the last scan, passed or not
  int failed_ = 0;                   ///< scans since the last fix
};

}  // namespace evermap
