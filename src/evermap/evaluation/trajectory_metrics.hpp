// SPDX-FileCopyrightText: 2026 the evermap authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstddef>
#include <vector>

#include <evermap/geometry/pose.hpp>

namespace evermap {

/// How far a trajectory is from the true one, pose by pose: the absolute trajectory error, ATE.
struct TrajectoryError {
  static constexpr double kLostDistance = 1.0;             ///< [m]
  static constexpr double kLostAngle = 0.087266462599716;  ///< [rad] 5 degrees

  std::vector<double> translation;  ///< [m] of each pose
  std::vector<double> rotation;     ///< [rad] of each pose, the angle of R_true' R
  double aligned_translation_rmse;  ///< [m] after the rigid motion that fits the positions best; it hides
                                    ///< what a shift of the whole map does

  double translation_rmse() const;  ///< [m] ATE, without alignment
  double translation_max() const;   ///< [m]
  double rotation_rmse() const;     ///< [rad]
  double rotation_max() const;      ///< [rad]
  double fraction_lost() const;     ///< of poses more than kLostDistance or kLostAngle off
};

/// Poses of one frame, paired by index. Without poses every figure is NaN.
/// REQUIRES: both have the same size.
TrajectoryError compare_trajectories(const std::vector<Pose>& T_map_sensor_true,
                                     const std::vector<Pose>& T_map_sensor);

/// The distance [m] along a trajectory.
double path_length(const std::vector<Pose>& T_map_sensor);

/// How fast the error grows with the distance: the mean, over all stretches of `stretch` [m] of the true path
/// (each pose begins one), of the error [m] of the motion along it, divided by `stretch`. NaN when the path
/// is shorter. REQUIRES: as of compare_trajectories; stretch > 0.
double drift(const std::vector<Pose>& T_map_sensor_true, const std::vector<Pose>& T_map_sensor,
             double stretch);

/// Indices of two poses that belong together.
struct PosePair {
  std::size_t found;
  std::size_t truth;
};

/// Pairs times [s] of which each is the other's nearest and no more than `tolerance` [s] away.
/// REQUIRES: both ascend strictly.
std::vector<PosePair> match_times(const std::vector<double>& found, const std::vector<double>& truth,
                                  double tolerance);

}  // namespace evermap
