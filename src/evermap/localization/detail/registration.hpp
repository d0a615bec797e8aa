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
  std::size_t first_bundles = 1000;  ///< that find the pose, evenly over the scan; then all refine it
  std::size_t least_matches = 50;    ///< bundles on the map, below which a pose is a guess
  double first_kernel_width = 6;     ///< Mahalanobis distance; wide at first, so that far leaves may pull,
  double last_kernel_width = 2;      ///< then halved from step to step down to this one
  double settling_width = 3;         ///< of the last kernel, in robust standard deviations of how far bundles
                                     ///< are off their leaves' planes; 0: none
  double damping = 1e-6;             ///< fraction of the Hessian's diagonal
  double least_inlier_fraction = 0.5;  ///< of the bundles on the map: chance alone gives a third
};

/// The covariance of a pose whose standard deviations are `shift` [m] and `turn` [rad] along any axis.
inline Matrix6 within(double shift, double turn) {
  return (Twist() << shift, shift, shift, turn, turn, turn).finished().cwiseAbs2().asDiagonal();
}

/// How far leaves of this edge [m] may mislead: the faces of a wall may lie in one.
inline Matrix6 systematic(double edge) {
  constexpr double kLever = 10;  // [m]
  return within(edge / 20, edge / 20 / kLever);
}

/// A pose and how well it is known: within about 1 m and 10 degrees, unless said otherwise.
struct PoseEstimate {
  Pose T_map_sensor;
  Matrix6 covariance = within(0.5, 0.1);  ///< of the twist of perturb() [m, rad]
};

/// Where a scan lies on the map.
struct Registration {
  Pose T_map_sensor;
  RejectReason reject_reason = RejectReason::kTooFewBundles;
  Matrix6 covariance = Matrix6::Zero();  ///< of the twist of perturb() [m, rad], the guess's included
  int unobservable = 0;                  ///< directions that are as they were guessed
  double matched_fraction = 0;           ///< of the bundles: where the map has a leaf
  double inlier_fraction = 0;            ///< of these: within the 95 % ellipsoid
  double fit = 0;       ///< how well the bundles lie on the map: 1, each in the plane of its leaf
  double residual = 0;  ///< mean squared Mahalanobis distance of the inliers
  int iterations = 0;

  bool converged() const { return reject_reason == RejectReason::kNone; }
  /// Of all bundles.
  double explained_fraction() const { return matched_fraction * inlier_fraction; }
  /// How well the scan fits the map there, less what lies beside its leaves. Chance alone gives 0 or less.
  double score() const { return fit - (matched_fraction - explained_fraction()); }
};

/// The bundles of a scan in its own frame, for registration; iterating then only transforms them. However
/// fine the map, they are at least 0.4 m wide: of smaller ones, most hold too few points to tell a plane.
/// Of more than `max_bundles`, as many are made, evenly spread.
std::vector<Gaussian> bundles_in_sensor_frame(
    const Scan& scan, double edge, const LidarParameters& lidar,
    std::size_t max_bundles = std::numeric_limits<std::size_t>::max());

/// What the bundles [sensor frame] say about the pose, linearized there.
NormalEquations equations_at(const Octree& map, const std::vector<Gaussian>& bundles_sensor,
                             const Pose& T_map_sensor, const RobustKernel& kernel);

/// Registers bundles [sensor frame] to the leaves of the map, distribution to distribution, from a pose that
/// is off by no more than about a leaf's edge (coarse_to_fine reaches further).
///
/// Minimizes the sum of w e' M e over the bundles, e = mu_V - T mu_R, M = (S_V + R S_R R')^-1 as far as
/// Factor counts it, with w the square root of the bundle's points times the leaf's occupancy times the
/// robust kernel. A few bundles come to rest first, matched anew only when the pose has moved by some
/// millimetres since they were; then all are matched, once, and refine the pose. Reads the map only; runs in
/// parallel in the caller's TBB arena, with the same result for any number of threads.
Registration register_bundles(const Octree& map, const std::vector<Gaussian>& bundles_sensor,
                              const PoseEstimate& guess, const RegistrationParameters& parameters);

/// As register_bundles, for poses that may be off by metres: registers to coarser and coarser views of the
/// map's leaves, too.
class CoarseToFine {
 public:
  /// For poses near `center_map` [m].
  CoarseToFine(const Octree& map, const Scan& scan, const Eigen::Vector3d& center_map,
               const LidarParameters& lidar, const RegistrationParameters& parameters);

  std::size_t views() const { return views_.size(); }

  /// Takes another scan of the same place.
  void set_scan(const Scan& scan);

  /// Registers to that many of the coarser views, the coarsest of them first, and then to the map. What a
  /// view does not know stays as the coarser ones had it.
  Registration from(const PoseEstimate& guess, std::size_t views) const;

 private:
  const Octree* map_;
  LidarParameters lidar_;
  RegistrationParameters parameters_;
  std::vector<Octree> views_;                 ///< the finest first
  std::vector<Gaussian> bundles_;             ///< for the map
  std::vector<std::vector<Gaussian>> wider_;  ///< for the views
};

/// From a pose that is off by no more than about 1 m and 10 degrees.
Registration register_coarse_to_fine(const Octree& map, const Scan& scan, const PoseEstimate& guess,
                                     const LidarParameters& lidar, const RegistrationParameters& parameters);

/// [m] The narrowest leaves that a sensor's own scans may be registered to. What its rings leave in narrower
/// ones are lines, which move with the sensor: it would seem to stand still.
double least_mapping_edge(const Scan& scan, const LidarParameters& lidar);

}  // namespace evermap
