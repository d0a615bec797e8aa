// SPDX-FileCopyrightText: 2026 the evermap authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <span>

#include <evermap/io/map_export.hpp>

namespace evermap {

/// OctoMap's files, for export_map. .ot: one voxel a leaf at its log-odds. .bt: the voxels alone. A map that
/// lies too far from its frame's origin for OctoMap's 16-bit keys throws FileError.
std::span<const MapFormat> octomap_formats();

}  // namespace evermap
