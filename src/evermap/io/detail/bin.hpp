// SPDX-FileCopyrightText: 2026 the evermap authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstddef>
#include <filesystem>
#include <optional>

#include <evermap/io/detail/cloud_notes.hpp>
#include <evermap/scan/scan.hpp>

namespace evermap {

/// The values a point that a .bin file may have.
inline constexpr std::size_t kLeastBinFields = 3;
inline constexpr std::size_t kMostBinFields = 64;

/// Reads a scan without header: float32, little endian, x y z [m, sensor frame] first in each point.
///
/// `fields` is the number of values a point. Without it, the data tells: 4 (KITTI: intensity), 5 (nuScenes: a
/// ring, too), 6 (Waymo, Boreas) or 3, whichever makes columns of a kind out of all values of the file. Files
/// of fewer than 100 points are read as 4. Throws FileError when the file cannot be read, is no whole number
/// of points, or two layouts fit equally well.
Scan read_bin(const std::filesystem::path& path, std::optional<std::size_t> fields = std::nullopt,
              CloudNotes* notes = nullptr);

}  // namespace evermap
