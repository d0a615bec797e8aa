// SPDX-FileCopyrightText: 2026 the evermap authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <evermap/geometry/pose.hpp>
#include <evermap/scan/scan.hpp>
#include <evermap/simulation/ray_caster.hpp>

namespace evermap {

/// What the true surfaces around a scan tell of its pose: an independent, slow judge that knows nothing of
/// maps.
///
/// Each of some thousand points pulls along the true normal of the surface that it is on. A direction of the
/// pose is observable when all of them together tell it to 5 mm, or as much of a turn as moves what is seen
/// by 5 mm.
class PoseJudge {
 public:
  /// `points`: of the scan, in the sensor frame [m], motion distortion undone.
  PoseJudge(const RayCaster& world, const std::vector<Eigen::Vector3d>& points, const Pose& T_map_sensor);

  bool is_observable() const { return observable_.cols() == 6; }

  /// How far a pose is off, in what is observable: [m] and [rad].
  struct Error {
    double translation;
    double rotation;
  };
  Error error(const Pose& T_map_found) const;

 private:
  using Directions = Eigen::Matrix<double, 6, Eigen::Dynamic>;

  Pose T_map_sensor_;
  double lever_;           ///< [m] by which a turn moves what is seen
  Directions observable_;  ///< orthonormal, turns times the lever
};

}  // namespace evermap
