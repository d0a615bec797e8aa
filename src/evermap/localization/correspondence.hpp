// SPDX-FileCopyrightText: 2026 the evermap authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <optional>

#include <evermap/geometry/gaussian.hpp>
#include <evermap/map/octree.hpp>

namespace evermap {

/// The leaf that a bundle belongs to, and what it says about where the bundle should be.
///
/// Of M = (S_V + S_R)^-1 only the stiffest axis counts, and only as far as it is stiffer than the next: a
/// patch of surface says where it is along its normal. Within its plane two patches attract each other's
/// means, too, but only because the voxels' walls cut the plane and the beams fell where they fell; that says
/// nothing about the world. Measured in the yard at l = 0.2 m, from within 1 m and 10 degrees: with all of M,
/// 52 of 100 starts missed 1 cm or 0.1 degree; with this, none of 1000.
struct Correspondence {
  Eigen::Vector3d residual;     ///< e = mu_V - mu_R [m], map frame
  Eigen::Matrix3d information;  ///< (lambda_3 - lambda_2) n n' of M's eigenvalues [1/m^2]
  double mahalanobis_squared;   ///< e' M e, with all of M
  double occupancy;             ///< probability that the leaf is there
};

/// The occupied leaf nearest to the bundle by Mahalanobis distance, among the bundle's own voxel and the six
/// that share a face with it; none when all are empty. `bundle` is in the map frame.
std::optional<Correspondence> correspond(const Octree& map, const Gaussian& bundle);

}  // namespace evermap
