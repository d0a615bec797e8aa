// SPDX-FileCopyrightText: 2026 the evermap authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <filesystem>

#include <evermap/io/detail/cloud_notes.hpp>
#include <evermap/scan/scan.hpp>

namespace evermap {

/// Reads the coordinates of a LAS file, version 1.0 to 1.4 (ASPRS), [m] if the file's are. Throws FileError
/// when it is missing, damaged, or compressed (LAZ).
Scan read_las(const std::filesystem::path& path, CloudNotes* notes = nullptr);

}  // namespace evermap
