// SPDX-FileCopyrightText: 2026 the evermap authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <deque>
#include <numbers>

#include <evermap/geometry/detail/running_median.hpp>
#include <evermap/localization/detail/hypothesis.hpp>

namespace evermap {

/// What a registered pose must satisfy before anything is believed of it. A registration that converged is
/// not enough: among posts of equal spacing it converges one post off.
struct GateParameters {
  double max_translation = 0.3;  ///< [m] from a prediction over 0.1 s, or 3 sigma of how far
                                 ///< passed scans were from theirs, if that is more
  double max_rotation = 3 * std::numbers::pi / 180;  ///< [rad] likewise
  double max_growth = 2;                             ///< by which 3 sigma may widen these two
  double max_residual = 3;                           ///< times the median of what passed before
  double least_inlier_fraction = 0.75;               ///< times the median of what passed before
  double max_contradicting = 0.15;  ///< fraction of a scan's rays, beyond the median of what passed before
  double margin = 0.1;        ///< of what the best place explains: it must score so much better than others
  std::size_t memory = 51;    ///< [scans] that the medians are taken over
  double starting_slack = 6;  ///< times the distances, while the motion is not known
  double max_jump = 0.6;      ///< [m] by which odometry may leave constant velocity in 0.1 s: no
                              ///< vehicle can, so that its wheels have slipped
  double max_turn_jump = 20 * std::numbers::pi / 180;  ///< [rad] likewise
  int lost_after = 5;                                  ///< [scans] in a row that did not pass
};

/// Judges registrations, remembering those that passed.
class Gate {
 public:
  explicit Gate(const GateParameters& parameters)
      : parameters_(parameters),
        residuals_(parameters.memory),
        explained_(parameters.memory),
        contradicting_(parameters.memory),
        score_changes_(parameters.memory) {}

  /// Whether this pose is to be believed (kNone), or why not. `slack` widens the distance to the prediction.
  RejectReason judge(const Registration& registration, const Pose& T_map_sensor_predicted,
                     double slack) const;
  /// As judge, of the best of several places, their rays counted. What is unusual, or far from the
  /// prediction, is then believed if nothing speaks for another place: turns are sharp, and maps outdated.
  RejectReason judge_best(const std::vector<Hypothesis>& places, std::size_t best,
                          const Pose& T_map_sensor_predicted, double slack) const;
  /// Whether a registration fits about as well as those that passed before, and as the last of them; false
  /// as long as there are few.
  bool is_usual(const Registration& registration) const;
  bool knows_what_is_usual() const { return explained_.is_known(); }
  /// By how much a score must differ to mean anything: three standard deviations from scan to scan.
  double least_difference() const;
  /// Whether so many contradictions are unusual.
  bool is_contradicting(double fraction) const;
  /// Takes a scan that passed. `is_predicted`: whether its prediction came from known motion.
  void remember(const Registration& passed, const Pose& T_map_sensor_predicted, bool is_predicted);
  void remember_contradicting(double fraction) { contradicting_.push(fraction); }

 private:
  RejectReason judge_distance(const Registration& registration, const Pose& T_map_sensor_predicted,
                              double slack) const;
  RejectReason judge_fit(const Registration& registration) const;

  GateParameters parameters_;
  std::deque<double> translations_;  ///< [m] from prediction to pose
  std::deque<double> rotations_;     ///< [rad]
  RunningMedian residuals_;
  RunningMedian explained_;      ///< fraction of the bundles
  RunningMedian contradicting_;  ///< fraction of the rays
  RunningMedian score_changes_;  ///< from scan to scan
  double last_score_ = 0;        ///< of what passed
};

}  // namespace evermap
