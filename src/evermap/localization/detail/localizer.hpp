// SPDX-FileCopyrightText: 2026 the evermap authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <functional>
#include <optional>
#include <vector>

#include <evermap/localization/detail/ego_motion.hpp>
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

  double time = 0;  ///< [s] when the scan ended
  EgoMotion ego;    ///< what the robot's other sensors said then
  Pose T_map_sensor_predicted;
  Scan scan;                       ///< deskewed, its points all as of `time`
  Twist velocity = Twist::Zero();  ///< [m/s, rad/s] in the sensor's frame, by which its end was deskewed
  bool is_deskewed = false;        ///< it had times
  Twist motion = Twist::Zero();    ///< [m/s, rad/s] since the last fix, or in this scan where it told
  bool motion_is_known = false;    ///< the prediction came from odometry or from a known velocity
  bool odometry_jumps = false;     ///< and is therefore not followed
  std::optional<double> contradicting_fraction;  ///< of the scan's rays there, where they were counted

  bool passes() const { return reject_reason == RejectReason::kNone; }
  /// Whether the scan may be written into a map that it extends.
  bool is_writable() const { return passes() && motion_is_known && !odometry_jumps; }
  /// Whether it may be written into a map that it is to correct: its pose must be known in every direction.
  bool is_precise() const;
};

/// How much of the map a scan contradicts at a pose; see contradicting_fraction().
using Contradicting = std::function<double(const Scan& scan, const Pose& T_map_sensor)>;

/// How many places are considered for a scan.
enum class Effort {
  kUsual,     ///< one, the predicted, unless it is in doubt
  kThorough,  ///< several
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
  /// constant velocity and the gyroscope without.
  Pose predict(double time, const EgoMotion& ego) const;

  /// Where the map began: a scan whose pose is given, and the velocity then, where known.
  void begin(const Pose& T_map_sensor, double time, const EgoMotion& ego,
             const std::optional<Twist>& velocity = std::nullopt);

  /// A scan whose sensor moved at `velocity` [m/s, rad/s], as if it had been taken at once at its end.
  Scan undistorted(const Scan& raw, const Twist& velocity) const;

  /// Registers a scan that ended at `time` [s], deskewed by the motion that was found, and lets the gate
  /// judge it. With odometry, it is to be given for each. At the start, when lost and when in doubt several
  /// places are considered; with `contradicting`, the rays have a say, too: a scan that is taken for lying
  /// behind a wall shoots through it.
  Localization propose(const Octree& map, const Scan& raw, double time, const EgoMotion& ego,
                       const Contradicting& contradicting = {}, Effort effort = Effort::kUsual) const;

  /// The same for a scan from before the last pose that passed, whose motion was not known at its time. Its
  /// state is set, too: it is not to be concluded.
  Localization propose_earlier(const Octree& map, const Scan& raw, double time, const EgoMotion& ego,
                               const Contradicting& contradicting, Effort effort) const;

  /// Whether so many contradictions are unusual.
  bool is_contradicting(double fraction) const { return gate_.is_contradicting(fraction); }

  /// Takes what was proposed; a caller who does not believe it has set its reject reason before. Sets its
  /// state, and its reject reason when the pose is believed but not the odometry.
  void conclude(Localization& found);

  TrackingState state() const { return state_; }

 private:
  /// A pose that passed the gate, and when.
  struct Fix {
    Pose T_map_sensor;
    Matrix6 covariance;
    Twist velocity;  ///< [m/s, rad/s] in the sensor's frame, by which the scan was deskewed
    double time;     ///< [s]
    EgoMotion ego;
  };

  /// When a scan ended, and what was known of the sensor's motion then.
  struct Moment {
    double time;  ///< [s]
    EgoMotion ego;
  };

  Localization locate(const Octree& map, const Scan& raw, double time, const EgoMotion& ego,
                      const Contradicting& contradicting, Effort effort) const;
  /// How much wider the gate is for a prediction over more than one period. REQUIRES: there was a fix.
  double slack(double time) const;
  double slack(const Localization& found) const;
  bool is_lost() const { return state_ == TrackingState::kLost; }
  /// How the sensor moves [m/s, rad/s] when it gets from the last fix to a pose at `time` [s].
  Twist velocity_to(const Pose& T_map_sensor, double time) const;
  /// How the sensor moved [m/s, rad/s] since the last fix, to a pose of a scan deskewed by `velocity`; from
  /// the middle of the one scan to the middle of the other. There, a scan is registered however wrong it was
  /// deskewed; velocities from one end to the next would swing up.
  Twist velocity_between_middles(const Pose& T_map_sensor, const Twist& velocity,
                                 const Localization& found) const;
  /// How the sensor moves [m/s, rad/s] by odometry since the last scan, passed or not.
  std::optional<Twist> velocity_by_odometry(double time, const EgoMotion& ego) const;
  /// How far odometry leaves constant velocity, for 0.1 s; zero where either is unknown.
  Twist odometry_off_steady(double time, const EgoMotion& ego) const;
  bool odometry_jumps(double time, const EgoMotion& ego) const;
  /// Whether the prediction is the odometry's.
  bool has_odometry(const Localization& found) const;
  /// Whether no scan was believed yet in a map that was there before.
  bool is_starting() const { return state_ == TrackingState::kStarting && !is_own_map_; }
  /// Whether some direction is known too badly for the pose to be of use.
  bool is_vague(const Localization& found) const;
  /// How well the prediction is known.
  Matrix6 uncertainty(const Localization& found, double time) const;
  Registration register_near(const Octree& map, const Scan& scan, const PoseEstimate& predicted) const;
  /// From all that the scan may look like from the prediction on: turns, speeds, wide and narrow views.
  std::vector<Hypothesis> guess_around(const Octree& map, const Scan& raw, const PoseEstimate& predicted,
                                       const Localization& found) const;
  std::vector<Hypothesis> search(const Octree& map, const Localization& found) const;
  /// Moves a place to where, within half a metre, the scan fits better.
  void look_beside(const Octree& map, const Matrix6& covariance, Hypothesis& place) const;
  /// Chooses among several places.
  void consider_places(const Octree& map, const Scan& raw, const PoseEstimate& predicted,
                       const Contradicting& contradicting, Localization& found) const;
  void take(Hypothesis&& place, Localization& found) const;
  /// Where the sensor was when a scan began. `edge` [m]: of the map's leaves. REQUIRES: there was a fix.
  PoseEstimate begin_of(const Localization& found, double edge) const;
  /// Where the scan is if the sensor moved like this, from a guess of its pose.
  Hypothesis moving(const Octree& map, const Scan& raw, const ScanMotion& motion,
                    const PoseEstimate& guess) const;
  /// Deskews by how it moved since the middle of the last scan, and registers once more.
  void undistort_again(const Octree& map, const Scan& raw, const Matrix6& covariance,
                       const Localization& found, Hypothesis& place) const;
  /// Where the sensor did not move as assumed, deskews by how it moved, and registers once more.
  void refit(const Octree& map, const Scan& raw, const Matrix6& covariance, const Localization& found,
             Hypothesis& place) const;
  /// Takes another place where the sensor is if it suddenly turned, or went straight, and more fits there.
  void try_turns(const Octree& map, const Scan& raw, const Matrix6& covariance, const Localization& found,
                 Hypothesis& place) const;
  /// [rad] how the sensor turned since the last fix, about its axes then; none where no gyroscope tells.
  std::optional<Eigen::Vector3d> turn_by_gyroscope(const EgoMotion& ego) const;
  /// A gyroscope that stands still says that it turns a little; the map knows better.
  void learn_bias(const Localization& found);
  void pass(const Localization& found);
  void fail();

  LidarParameters lidar_;
  LocalizationParameters parameters_;
  Gate gate_;
  TrackingState state_ = TrackingState::kStarting;
  Pose T_map_sensor_initial_;
  bool is_own_map_ = false;        ///< made of this robot's scans alone, since begin()
  std::optional<Fix> last_;        ///< none before the first
  std::optional<Twist> velocity_;  ///< [m/s, rad/s] in the sensor's frame, once two fixes tell it
  Eigen::Vector3d gyroscope_bias_ = Eigen::Vector3d::Zero();  ///< [rad/s] in the sensor's frame
  double biases_ = 0;                                         ///< [scans] it was learnt from
  EgoMotion first_ego_;                                       ///< of the first scan, passed or not
  std::optional<Moment> last_scan_;                           ///< passed or not
  int failed_ = 0;                                            ///< scans since the last fix
  int unobservable_ = 0;  ///< fixes since the last whose directions were all observable
  double tied_ = 0;  ///< explained by the best of places that tied since the last scan that passed: a place
                     ///< that explains less is not where the robot is
};

}  // namespace evermap
