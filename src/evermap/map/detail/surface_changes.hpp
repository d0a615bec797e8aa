// SPDX-FileCopyrightText: 2026 the evermap authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstddef>
#include <vector>

#include <Eigen/Geometry>

#include <evermap/map/map_difference.hpp>

namespace evermap {

/// Whether a map shows a surface at `p_map`, which lies in the voxel of `key`: see MapDifference.
bool shows_surface(const Octree& octree, VoxelKey key, const Eigen::Vector3d& p_map);

/// Surface that came or went: leaves that touch each other.
struct SurfaceChange {
  bool has_come = true;
  Eigen::AlignedBox3d box;  ///< [m] map frame
  std::size_t leaves = 0;
};

/// What came and went between two maps of one grid, in pieces; pieces of one or two leaves are noise.
std::vector<SurfaceChange> surface_changes(const Octree& before, const Octree& after);

}  // namespace evermap
