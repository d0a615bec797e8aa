// SPDX-FileCopyrightText: 2026 the evermap authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <filesystem>

#include <evermap/io/detail/cloud_notes.hpp>
#include <evermap/scan/scan.hpp>

namespace evermap {

/// Reads a text with one point a line: numbers divided by blanks, commas or semicolons, of which the first
/// three are x y z, unless a first line names the columns. Lines that begin with # or // are skipped, and a
/// first line that holds one number, the count. Throws FileError naming the line that is something else.
Scan read_text_cloud(const std::filesystem::path& path, CloudNotes* notes = nullptr);

}  // namespace evermap
