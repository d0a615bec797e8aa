// SPDX-FileCopyrightText: 2026 the evermap authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <filesystem>
#include <string_view>

#include <evermap/map/octree.hpp>

namespace evermap {

/// The extensions that export_map knows, for messages.
inline constexpr std::string_view kExportExtensions = ".pcd, .ply, .ot and .bt (OctoMap)";

/// Throws FileError, listing those known, when export_map does not know the extension of `path`.
void check_export_extension(const std::filesystem::path& path);

/// Writes the occupied leaves for other programs, atomically; the format follows from the extension (any
/// case).
///
/// .pcd and .ply: one point a leaf, the mean of its Gaussian [m, map frame], with the fields `x y z cov_xx
/// cov_xy cov_xz cov_yy cov_yz cov_zz occupancy count` (covariance in m^2, occupancy as a probability);
/// coordinates are float32, or float64 in a map that reaches beyond 10 km from the origin. .ot: one voxel a
/// leaf at its log-odds. .bt: the voxels alone. Throws FileError when the file cannot be written, the
/// extension is unknown, or the map lies too far from its frame's origin for OctoMap's 16-bit keys.
void export_map(const Octree& octree, const std::filesystem::path& path);

}  // namespace evermap
