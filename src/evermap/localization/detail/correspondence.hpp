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
  Eigen::Vector3d mean_leaf;  ///< mu_V [m], map frame; of a wall whose faces share the leaf, the near face's
  Eigen::Matrix3d information;  ///< M = (S_V + S_R)^-1 [1/m^2], S_V the face's likewise
  Eigen::Vector3d normal;       ///< M's stiffest axis, the better the stiffer it is
  double mahalanobis_squared;   ///< e' M e, e = mu_V - mu_R
  double occupancy;             ///< probability that the leaf is there
};

/// Of each bundle the occupied leaf that is nearest by Mahalanobis distance, among the voxel of the bundle's
/// mean and, where that holds no leaf or a face is near, those across the nearest faces; none when all are
/// empty. What a face close in front hides from the sensor does not count.
std::vector<std::optional<Correspondence>> correspond(const Octree& map,
                                                      std::span<const Gaussian> bundles_sensor,
                                                      const Pose& T_map_sensor);

/// The axis of the greatest eigenvalue of a positive symmetric matrix, the better the greater it is than the
/// next.
Eigen::Vector3d stiffest_axis(const Eigen::Matrix3d& information);

}  // namespace evermap
