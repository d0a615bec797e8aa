// SPDX-FileCopyrightText: 2026 the evermap authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <Eigen/Core>

#include <evermap/geometry/pose.hpp>

namespace evermap {

/// How registration moves a pose: a perturbation on the left, in the map's axes, that turns about the sensor.
///
///   T = (R, t)  ->  (exp(phi) R, t + rho),   twist = (rho [m], phi [rad])
///
/// Turning about the sensor instead of the map's origin keeps translation and rotation apart, however far the
/// map's origin is. Covariances and information matrices of poses are of this twist.
inline Pose perturb(const Pose& T_map_sensor, const Twist& twist) {
  Twist turn = Twist::Zero();
  turn.tail<3>() = twist.tail<3>();
  return {exp(turn).rotation * T_map_sensor.rotation, T_map_sensor.translation + twist.head<3>()};
}

/// The twist between two poses: perturb(from, difference(from, to)) = to.
inline Twist difference(const Pose& from, const Pose& to) {
  Twist twist = log({to.rotation * from.rotation.transpose(), Eigen::Vector3d::Zero()});
  twist.head<3>() = to.translation - from.translation;
  return twist;
}

}  // namespace evermap
