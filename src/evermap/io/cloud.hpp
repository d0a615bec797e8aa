// SPDX-FileCopyrightText: 2026 the evermap authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <filesystem>

#include <evermap/scan/scan.hpp>

namespace evermap {

/// Reads a point cloud or scan; the format follows from the extension (.bin .pcd .ply, any case).
/// Throws IoError when the file is missing, malformed or of another kind.
Scan read_cloud(const std::filesystem::path& path);

}  // namespace evermap
