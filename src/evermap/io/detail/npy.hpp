// SPDX-FileCopyrightText: 2026 the evermap authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <filesystem>

#include <evermap/io/detail/cloud_notes.hpp>
#include <evermap/scan/scan.hpp>

namespace evermap {

/// Reads an array that NumPy saved: numbers of shape (points, 3 or more), of which the first three are x y z,
/// also (rows, columns, 3 or more); or records with fields x, y and z. Throws FileError when it is anything
/// else.
Scan read_npy(const std::filesystem::path& path, CloudNotes* notes = nullptr);

}  // namespace evermap
