// SPDX-FileCopyrightText: 2026 the evermap authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <filesystem>

#include <evermap/io/detail/cloud_notes.hpp>
#include <evermap/io/detail/point_table.hpp>
#include <evermap/scan/scan.hpp>

namespace evermap {

/// Reads a PCD file of version 0.5 to 0.7: ascii, binary or binary_compressed (both little endian), fields of
/// any order, type and count, see ScanBuilder for those used. T_map_sensor is the VIEWPOINT; it stays empty
/// for the viewpoint 0 0 0 1 0 0 0, because that is what PCL writes when it knows none. Bytes behind the last
/// binary point are ignored: PCL pads files to whole pages. Throws FileError when the file is damaged.
Scan read_pcd(const std::filesystem::path& path, CloudNotes* notes = nullptr);

/// Writes a binary PCD file of version 0.7, atomically. Throws FileError when it cannot be written,
/// std::invalid_argument when the table is malformed.
void write_pcd(const std::filesystem::path& path, const PointTable& table);

}  // namespace evermap
