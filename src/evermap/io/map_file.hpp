// SPDX-FileCopyrightText: 2026 the evermap authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <filesystem>

#include <evermap/map/octree.hpp>

namespace evermap {

/// The newest version of the format that load_map reads. save_map writes it for maps whose frame has a name
/// of its own or a place on earth, and version 1, which tells neither, for others.
inline constexpr std::uint32_t kMapFormat = 2;

/// Leaf edges that a map may have [m]: below, range noise is wider than a leaf; above, one Gaussian cannot
/// describe what is in it.
inline constexpr double kLeastLeafEdge = 0.05;
inline constexpr double kGreatestLeafEdge = 2.0;
/// Also false for NaN.
inline bool is_leaf_edge(double edge) { return edge >= kLeastLeafEdge && edge <= kGreatestLeafEdge; }

/// Writes the map to an `.evm` file, atomically; docs/map_format.md gives every byte. Equal maps give equal
/// bytes. Throws FileError when the file cannot be written, or the map holds what load_map would refuse (a
/// value that is not finite, say): then the old file is still in place.
void save_map(const std::filesystem::path& path, const Octree& octree);

/// Reads what save_map wrote. Throws FileError naming block and byte when the file is no map, is of a newer
/// format, or differs from what was written in a single bit or in its length. Needs no more memory than a
/// small multiple of the file's true size, whatever the file claims.
Octree load_map(const std::filesystem::path& path);

}  // namespace evermap
