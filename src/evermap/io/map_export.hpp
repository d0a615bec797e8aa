// SPDX-FileCopyrightText: 2026 the evermap authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <filesystem>
#include <span>
#include <string_view>

#include <evermap/map/octree.hpp>

namespace evermap {

/// A format of other programs, chosen by the extension of a file's name.
struct MapFormat {
  std::string_view extension;  ///< in lower case, with its dot
  void (*write)(const Octree& octree, const std::filesystem::path& path);
};

/// .pcd and .ply: one point a leaf, the mean of its Gaussian [m, map frame], with the fields `x y z cov_xx
/// cov_xy cov_xz cov_yy cov_yz cov_zz occupancy count` (covariance in m^2, occupancy as a probability);
/// coordinates are float32, or float64 in a map that reaches beyond 10 km from the origin.
///
/// .las: the means, to the millimetre. .pgm: a picture of what is free and what is occupied, for Nav2, with
/// its .yaml beside it (see write_occupancy_grid).
std::span<const MapFormat> cloud_formats();

/// Throws FileError, listing the extensions known, when none of the formats has the extension of `path` (any
/// case).
void check_export_extension(const std::filesystem::path& path,
                            std::span<const MapFormat> formats = cloud_formats());

/// Writes the occupied leaves for other programs, atomically. Throws FileError when the file cannot be
/// written, the extension is unknown, or the format cannot hold this map.
void export_map(const Octree& octree, const std::filesystem::path& path,
                std::span<const MapFormat> formats = cloud_formats());

/// Writes the occupied leaves as a folder of .pcd tiles with an edge of `edge` [m] and the list that
/// Autoware's map loader reads (pointcloud_map_metadata.yaml), which is written last; where the map's origin
/// on earth is known, map_projector_info.yaml tells it. Returns the number of tiles. Throws FileError.
std::size_t export_tiles(const Octree& octree, const std::filesystem::path& folder, double edge);

}  // namespace evermap
