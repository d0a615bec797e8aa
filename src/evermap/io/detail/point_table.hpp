// SPDX-FileCopyrightText: 2026 the evermap authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstddef>
#include <string>
#include <vector>

#include <evermap/io/detail/atomic_file.hpp>

namespace evermap {

/// Points with any number of named values each, to be written to a PCD or PLY file.
///
/// Class invariant (`validate`): there is a column, names are not empty and hold no blanks, and `values` is a
/// whole number of rows.
struct PointTable {
  /// How a value is stored in the file. Coordinates far from the origin need kFloat64: at 10^6 m a float32
  /// steps by 6 cm.
  enum class Type { kFloat32, kFloat64 };
  struct Column {
    std::string name;
    Type type = Type::kFloat32;
  };

  std::vector<Column> columns;
  std::vector<double> values;  ///< row-major, rows() x columns.size()

  std::size_t rows() const { return columns.empty() ? 0 : values.size() / columns.size(); }

  /// Throws std::invalid_argument when the invariant does not hold.
  void validate() const;
};

/// Appends the values of `table` to `file`, row by row, packed, little endian.
void write_rows(AtomicFile& file, const PointTable& table);

}  // namespace evermap
