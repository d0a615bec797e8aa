// SPDX-FileCopyrightText: 2026 the evermap authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <vector>

#include <Eigen/Core>

#include <evermap/evaluation/map_metrics.hpp>
#include <evermap/geometry/voxel_key.hpp>

namespace evermap {

/// The rays of one scan, in the map frame.
struct ScanRays {
  Eigen::Vector3d origin;  ///< [m]
  Points ends;             ///< [m]
};

/// Of each point: the number of rays, up to 255, that crossed its voxel and went more than `margin` [m]
/// beyond the voxel's far side. To touch a voxel in a corner or along an edge is not to cross it. A point or
/// an end that has no key in the grid counts nothing.
std::vector<std::uint8_t> rays_beyond(const Points& points, const VoxelGrid& grid,
                                      const std::vector<ScanRays>& scans, double margin);

/// The same for scans, of each of which one ray is enough.
std::vector<std::uint8_t> scans_beyond(const Points& points, const VoxelGrid& grid,
                                       const std::vector<ScanRays>& scans, double margin);

/// Those of `points` that rays could contradict: at least 4 went more than 1.5 voxels beyond. On these a map
/// may be scored for what it keeps and erases.
Points contradictable(const Points& points, const VoxelGrid& grid, const std::vector<ScanRays>& scans);

}  // namespace evermap
