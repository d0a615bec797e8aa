// SPDX-FileCopyrightText: 2026 the evermap authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <optional>
#include <vector>

#include <evermap/localization/detail/registration.hpp>
#include <evermap/scan/detail/deskew.hpp>

namespace evermap {

/// How a sensor may have moved while it took a scan, and where it then was at the scan's end.
struct MovingPose {
  ScanMotion motion;
  Pose T_map_sensor;
};

/// Before a scan: where its sensor was when it began, how it can move, and where odometry says that it is.
struct MotionPrior {
  PoseEstimate begin;  ///< where the scan before ended
  Matrix6 drift;       ///< covariance [m, rad] of what a scan's end may be off, for another velocity
  std::optional<PoseEstimate> end;  ///< by odometry, which says nothing of the way there
};

/// Motions that explain a scan better than the `assumed` one, by which `deskewed` was made of `raw`, and with
/// which it was registered: at one velocity, and at one to some moment and at another from there on. None
/// where the assumed one explains it about as well.
///
/// Parts of the scan, taken one after the other, are held against the map each for itself; what they say
/// about where the sensor was then is joined, from where the scan began. Vehicles enter turns within a scan;
/// one velocity for all of it leaves the pose at its end off by degrees. REQUIRES: has_times(raw).
std::vector<MovingPose> fit_motion(const Octree& map, const Scan& raw, const Scan& deskewed,
                                   const MovingPose& assumed, const MotionPrior& prior,
                                   const LidarParameters& lidar, const RegistrationParameters& parameters);

/// A few of the motions by which a vehicle that moved at `before` may have taken the scan: it went on, or
/// turned from some moment on, or no longer. Of these the one by which most of the scan fits the map.
MovingPose best_turn(const Octree& map, const Scan& raw, const Pose& T_map_begin, const Twist& before,
                     const LidarParameters& lidar, const RegistrationParameters& parameters);

}  // namespace evermap
