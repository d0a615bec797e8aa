// SPDX-FileCopyrightText: 2026 the evermap authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <filesystem>
#include <vector>

#include <evermap/io/detail/cloud_notes.hpp>
#include <evermap/scan/scan.hpp>

namespace evermap {

/// Reads the coordinates of a LAS file, version 1.0 to 1.4 (ASPRS), [m] if the file's are. Throws FileError
/// when it is missing, damaged, or compressed (LAZ).
Scan read_las(const std::filesystem::path& path, CloudNotes* notes = nullptr);

/// Writes points as LAS 1.2, format 0, atomically, to the millimetre. Throws FileError when the file cannot
/// be written, or the points reach further than that allows (2,000 km).
void write_las(const std::filesystem::path& path, const std::vector<Eigen::Vector3d>& points);

}  // namespace evermap
