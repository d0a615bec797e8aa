// SPDX-FileCopyrightText: 2026 the evermap authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <filesystem>

#include <evermap/io/detail/cloud_notes.hpp>
#include <evermap/scan/scan.hpp>

namespace evermap {

/// Reads the occupied voxels of an OctoMap, .bt (binary) or .ot (full, OcTree or ColorOcTree): a point in the
/// middle of each voxel of the map's resolution, those of pruned branches, too. Throws FileError when it is
/// anything else, or holds more voxels than greatest_expansion() allows.
Scan read_octomap(const std::filesystem::path& path, CloudNotes* notes = nullptr);

}  // namespace evermap
