// SPDX-FileCopyrightText: 2026 the evermap authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <optional>
#include <span>
#include <vector>

#include <evermap/geometry/gaussian.hpp>
#include <evermap/map/octree.hpp>

namespace evermap {

/// The leaf that a bundle belongs to.
struct Correspondence {
  Eigen::Vector3d mean_leaf;    ///< mu_V [m], map frame
  Eigen::Matrix3d information;  ///< M = (S_V + S_R)^-1 [1/m^2]
  double mahalanobis_squared;   ///< e' M e, e = mu_V - mu_R
  double occupancy;             ///< probability that the leaf is there
};

/// Of each bundle the occupied leaf that is nearest by Mahalanobis distance, among the voxel of the bundle's
/// mean and, where that holds no leaf or a face is near, those across the nearest faces; none when all are
/// empty.
std::vector<std::optional<Correspondence>> correspond(const Octree& map,
                                                      std::span<const Gaussian> bundles_sensor,
                                                      const Pose& T_map_sensor);

}  // namespace evermap
