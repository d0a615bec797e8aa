// SPDX-FileCopyrightText: 2026 the evermap authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

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
  double share_lost() const;        ///< of poses more than kLostDistance or kLostAngle off
};

/// Poses of one frame, paired by index. Without poses every figure is NaN.
/// REQUIRES: both have the same size.
TrajectoryError compare_trajectories(const std::vector<Pose>& T_map_sensor_true,
                                     const std::vector<Pose>& T_map_sensor);

}  // namespace evermap
