// SPDX-FileCopyrightText: 2026 the evermap authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <filesystem>

#include <evermap/map/octree.hpp>

namespace evermap {

/// Writes what a ground vehicle can drive on as Nav2's map_server reads it: `path` (.pgm, one pixel a leaf's
/// edge) and the .yaml beside it. A cell is occupied when it has surface 0.15 to 2 m above the ground, free
/// when it has none but the ground, unknown when nothing was seen. The ground is the lowest surface that can
/// be reached within 2 m at a slope of 0.3; what little lies below it alone is none. Throws FileError when
/// they cannot be written, or the map is too wide.
void write_occupancy_grid(const Octree& octree, const std::filesystem::path& path);

}  // namespace evermap
