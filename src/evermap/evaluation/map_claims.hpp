// SPDX-FileCopyrightText: 2026 the evermap authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <Eigen/Core>

#include <evermap/evaluation/map_metrics.hpp>
#include <evermap/map/octree.hpp>

namespace evermap {

/// Whether the map still claims surface at this point: its leaf is occupied and the point lies in the 99 %
/// ellipsoid of S_V + u + position_sigma^2 I, where u is what the leaf's points do not tell of its extent
/// (predictive()): the map believes in it when it judges rays, too. `position_sigma` [m] is how well the
/// point itself is known: the pose's error for a point of a real scan, the range noise for a point of a
/// simulated world.
bool claims(const Octree& octree, const Eigen::Vector3d& p_map, double position_sigma);

/// Whether the map knows of anything at this point: what it claims, and pending leaves, too. Arguments as of
/// claims().
bool notices(const Octree& octree, const Eigen::Vector3d& p_map, double position_sigma);

/// The map as points [m]: the mean of every occupied leaf.
Points surface_points(const Octree& octree);

}  // namespace evermap
