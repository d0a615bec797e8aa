// SPDX-FileCopyrightText: 2026 the evermap authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <filesystem>

#include <evermap/io/detail/cloud_notes.hpp>
#include <evermap/io/detail/point_table.hpp>
#include <evermap/scan/scan.hpp>

namespace evermap {

/// Reads the vertices of a PLY file: ascii (one element per line) or binary of either byte order, properties
/// of any order and type, see ScanBuilder for those used. Other elements are skipped. Throws FileError when
/// the file is damaged, has no vertices, or its vertices have a list.
Scan read_ply(const std::filesystem::path& path, CloudNotes* notes = nullptr);

/// Writes a binary little-endian PLY file, atomically. Throws FileError when it cannot be written,
/// std::invalid_argument when the table is malformed.
void write_ply(const std::filesystem::path& path, const PointTable& table);

}  // namespace evermap
