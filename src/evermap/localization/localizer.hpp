// SPDX-FileCopyrightText: 2026 the evermap authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <optional>
#include <string_view>
#include <vector>

#include <evermap/localization/gate.hpp>
#include <evermap/localization/hypothesis.hpp>
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

/// All that governs localization.
struct LocalizationParameters {
  RegistrationParameters registration;
  GateParameters gate;
  RelocationParameters relocation;
};

/// A registered scan, and what is to be thought of its pose.
struct Localization {
  Pose T_map_sensor;                               ///< registered when that converged, otherwise predicted
  TrackingState state = TrackingState::kStarting;  ///< after this scan; set by Localizer::conclude
  RejectReason reject_reason = RejectReason::kNone;
  Registration registration;

  std::vector<Hypothesis> hypotheses;  ///< distinct places where the scan may be, the one thought of first
                                       ///< first
  bool is_contested = false;           ///< the first is not clearly the best: rays must decide
  Pose T_begin_end;                    ///< motion in the period before `time`, that was undone (see deskew)
  double time = 0;                     ///< [s] when the scan ended
  std::optional<Pose> T_odom_sensor;   ///< what odometry said then
  Pose T_map_sensor_predicted;
  double slack = 1;                         ///< times the gate's distances
  bool is_search = false;                   ///< the robot was lost
  bool motion_is_known = false;             ///< the prediction came from odometry or from a known velocity
  bool odometry_jumps = false;              ///< and is therefore not followed
  std::optional<Pose> T_map_sensor_before;  ///< of the scan before, anew, its motion undone, too

  bool passes() const { return reject_reason == RejectReason::kNone; }
  /// Whether the scan may be written into the map at this pose.
  bool is_writable() const { return passes() && motion_is_known && !odometry_jumps; }
};

/// How much is looked at.
enum class Effort {
  kUsual,     ///< the place that was predicted, others when that is in doubt
  kThorough,  ///< others in any case
};

/// Follows a sensor through a map, scan by scan: predict, register, compare, gate.
///
/// A scan takes three steps, so that whoever keeps the map has a word in between: `propose` registers it, at
/// several places when one is not clearly right; `choose` takes the best of them, once their rays have been
/// traced; `conclude` goes on from there. Predictions start from the last pose that passed the gate, never
/// from one that did not, so that a wrong pose cannot confirm itself. Where everything looks the same, the
/// map cannot tell that odometry slipped from one place to the next; so odometry that jumps is not followed.
/// Not thread safe.
class Localizer {
 public:
  Localizer(const Pose& T_map_sensor_initial, const LidarParameters& lidar,
            const LocalizationParameters& parameters);

  /// Where the sensor should be at `time` [s]: the last pose that passed, moved on by the odometry, or by
  /// constant velocity without.
  Pose predict(double time, const std::optional<Pose>& T_odom_sensor) const;

  /// How the sensor moves, by the same lights, in the `duration` [s] before `time`: what deskew needs.
  Pose motion(double time, const std::optional<Pose>& T_odom_sensor, double duration) const;

  /// Registers a scan as it came, its last points of `time` [s]. With odometry, it is to be given for each.
  Localization propose(const Octree& map, const Scan& raw, double time,
                       const std::optional<Pose>& T_odom_sensor, Effort effort = Effort::kUsual);

  /// Takes the best hypothesis and judges it. REQUIRES: when they are contested, their contradicting
  /// fractions are set.
  void choose(Localization& found) const;

  /// Takes what was chosen; a caller who does not believe it has set its reject reason before. Sets its
  /// state, and its reject reason when the pose is believed but not the odometry.
  void conclude(Localization& found);

  /// Takes a pose that needs no scan: where a map begins. `velocity`: [m/s, rad/s] in the sensor's frame,
  /// when it is known.
  void begin(const Pose& T_map_sensor, double time, const std::optional<Pose>& T_odom_sensor,
             const std::optional<Twist>& velocity = std::nullopt);

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
  /// Near the guess, with wider leaves where the map's own do not hold all directions.
  Registration register_near(const Octree& map, const Scan& scan, const Pose& T_map_sensor_guess) const;
  Scan undistorted(const Scan& raw, const Pose& T_begin_end) const;
  /// How the sensor moved in the period before, if it went from the last fix to here.
  Pose motion_to(const Pose& T_map_sensor, double time) const;
  std::vector<Registration> register_everywhere(const Octree& map, const Scan& scan,
                                                const Localization& found) const;
  /// Deskews anew with the motion that was found, until both agree.
  void undistort(const Octree& map, const Scan& raw, Localization& found) const;
  /// The same where the scan before was distorted, too, by a motion that nobody knew.
  void undistort_start(const Octree& map, const Scan& raw, Localization& found) const;
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
  std::optional<Scan> last_scan_;    ///< as it came, while the motion is not known
  int failed_ = 0;                   ///< scans since the last fix
  int blind_ = 0;                    ///< scans in a row that left a direction unobserved
};

}  // namespace evermap
