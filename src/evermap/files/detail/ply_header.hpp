// SPDX-FileCopyrightText: 2026 the evermap authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include <evermap/files/detail/record_layout.hpp>
#include <evermap/files/detail/text_lines.hpp>

namespace evermap {

enum class PlyEncoding { kAscii, kBinaryLittleEndian, kBinaryBigEndian };

struct PlyProperty {
  std::string name;
  Scalar type;
  std::optional<Scalar> list_count_type;  ///< of the integer before a list's values; none when no list
};

struct PlyElement {
  std::string name;
  std::uint64_t count = 0;
  std::vector<PlyProperty> properties;

  bool has_list() const;
};

/// What a PLY file says about itself before its data.
struct PlyHeader {
  PlyEncoding encoding = PlyEncoding::kAscii;
  std::vector<PlyElement> elements;  ///< in the order in which their data follows
};

/// Reads the header and leaves `lines` at its last one, end_header. Throws FileError naming the line that is
/// wrong.
PlyHeader read_ply_header(const InputFile& file, TextLines& lines);

}  // namespace evermap
