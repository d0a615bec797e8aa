// SPDX-FileCopyrightText: 2026 the evermap authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <filesystem>
#include <vector>

#include <evermap/scan/detail/labelled_box.hpp>

namespace evermap {

/// Reads a table of boxes, comma separated with a header line that names at least the columns `frame x y z
/// length width height yaw moving` in any order; other columns are ignored. Returns the boxes of scan i at
/// index i. Throws FileError naming the line for a missing column, a number that is none, or a negative size.
std::vector<std::vector<LabelledBox>> read_labelled_boxes(const std::filesystem::path& path);

}  // namespace evermap
