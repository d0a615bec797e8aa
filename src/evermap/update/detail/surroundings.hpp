// SPDX-FileCopyrightText: 2026 the evermap authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <vector>

#include <Eigen/Core>

#include <evermap/geometry/gaussian.hpp>
#include <evermap/map/octree.hpp>
#include <evermap/update/detail/impact.hpp>

namespace evermap {

/// The plane in which the occupied leaf of a voxel and those around it lie together, if they do: its normal
/// and thickness.
Plane plane_around(const Octree& octree, VoxelKey key);

/// The plane of the surface in a voxel: the leaf's own or, where few points make none, that of its
/// surroundings.
Plane plane_of_surface(const Octree& octree, VoxelKey key, const Gaussian& leaf);

/// A plane through a place of its own.
struct PlacedPlane {
  Plane plane;
  Eigen::Vector3d on_plane;  ///< [m] map frame
};

/// The planes of the surfaces that meet in a leaf without a plane: those of the flat leaves around it that go
/// through it, when two of them are at an angle, as along the foot of a wall; else none.
std::vector<PlacedPlane> corner_around(const Octree& octree, VoxelKey key, const Gaussian& leaf);

/// Whether something at `p_map` stands before a surface, as the sensor sees it, by more than `clearance` [m].
/// What has no plane tells of no surface, so everything may.
bool stands_before(const Plane& plane, const Eigen::Vector3d& on_plane, const Eigen::Vector3d& p_map,
                   const Eigen::Vector3d& origin_map, double clearance);

}  // namespace evermap
