// SPDX-FileCopyrightText: 2026 the evermap authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstddef>
#include <limits>
#include <string>
#include <vector>

#include <evermap/geometry/pose.hpp>
#include <evermap/localization/detail/factor.hpp>
#include <evermap/localization/detail/observability.hpp>
#include <evermap/localization/detail/termination.hpp>
#include <evermap/localization/reject_reason.hpp>
#include <evermap/map/octree.hpp>
#include <evermap/scan/detail/ray_bundle.hpp>

namespace evermap {

struct RegistrationParameters {
  Termination termination;
  std::size_t first_bundles = 1000;    ///< that find the pose, evenly over the scan; then all refine it
  std::size_t least_matches = 50;      ///< bundles on the map, below which a pose is a guess
  double first_kernel_width = 6;       ///< Mahalanobis distance; wide at first, so that far leaves may pull,
  double last_kernel_width = 2;        ///< then halved from step to step down to this one
  double damping = 1e-6;               ///< fraction of the Hessian's diagonal
  double least_inlier_fraction = 0.3;  ///< of all bundles
  double least_observability =
      0.03;  ///< information in any direction, as a fraction of the mean direction's;
             ///< endless corridors reach 0.016, an open junction has 0.06
};

/// Where a scan lies on the map.
struct Registration {
  Pose T_map_sensor;
  RejectReason reject_reason = RejectReason::kTooFewBundles;
  Matrix6 covariance = Matrix6::Zero();  ///< of the twist of perturb() [m, rad]; zero unless converged
  Observability weakest;                 ///< the direction that is known least
  double inlier_fraction = 0;            ///< of all bundles: on the map and within the 95 % ellipsoid
  double residual = 0;                   ///< mean squared Mahalanobis distance of the inliers
  int iterations = 0;

  bool converged() const { return reject_reason == RejectReason::kNone; }
};

/// The bundles of a scan in its own frame, for registration; iterating then only transforms them. However
/// fine the map, they are at least 0.4 m wide: of smaller ones, most hold too few points to tell a plane.
/// Of more than `max_bundles`, as many are made, evenly spread.
std::vector<Gaussian> bundles_in_sensor_frame(
    const Scan& scan, double edge, const LidarParameters& lidar,
    std::size_t max_bundles = std::numeric_limits<std::size_t>::max());

/// Registers bundles [sensor frame] to the leaves of the map, distribution to distribution, from a pose that
/// is off by no more than about a leaf's edge (coarse_to_fine reaches further).
///
/// Minimizes the sum of w e' M e over the bundles, e = mu_V - T mu_R, M = (S_V + R S_R R')^-1 as far as
/// Factor counts it, with w the square root of the bundle's points times the leaf's occupancy times the
/// robust kernel. A few bundles come to rest first, matched anew only when the pose has moved by some
/// millimetres since they were; then all are matched, once, and refine the pose. Reads the map only; runs in
/// parallel in the caller's TBB arena, with the same result for any number of threads.
Registration register_bundles(const Octree& map, const std::vector<Gaussian>& bundles_sensor,
                              const Pose& T_map_sensor_guess, const RegistrationParameters& parameters);

/// As register_bundles, from a pose that may be off by metres: registers to coarser and coarser views of the
/// map's leaves around the sensor, the coarsest first.
Registration register_coarse_to_fine(const Octree& map, const Scan& scan, const Pose& T_map_sensor_guess,
                                     const LidarParameters& lidar, const RegistrationParameters& parameters);

}  // namespace evermap
