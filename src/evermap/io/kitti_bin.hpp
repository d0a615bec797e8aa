// SPDX-FileCopyrightText: 2026 the evermap authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <filesystem>

#include <evermap/scan/scan.hpp>

namespace evermap {

/// Reads a scan of the KITTI data sets: x y z [m, sensor frame] intensity, float32, little endian, no header.
/// Throws FileError when the file cannot be read or is no whole number of points.
Scan read_kitti_bin(const std::filesystem::path& path);

}  // namespace evermap
