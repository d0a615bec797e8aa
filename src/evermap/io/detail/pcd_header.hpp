// SPDX-FileCopyrightText: 2026 the evermap authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <optional>

#include <evermap/files/detail/record_layout.hpp>
#include <evermap/files/detail/text_lines.hpp>
#include <evermap/geometry/pose.hpp>

namespace evermap {

enum class PcdEncoding { kAscii, kBinary, kBinaryCompressed };

/// What a PCD file says about itself before its points.
struct PcdHeader {
  RecordLayout layout;
  std::uint64_t points = 0;
  std::optional<Pose> T_map_sensor;  ///< none for the viewpoint 0 0 0 1 0 0 0
  PcdEncoding encoding = PcdEncoding::kAscii;
};

/// Reads the header and leaves `lines` at its last one, DATA. Throws FileError naming the line that is wrong.
PcdHeader read_pcd_header(const InputFile& file, TextLines& lines);

}  // namespace evermap
