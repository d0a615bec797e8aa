// SPDX-FileCopyrightText: 2026 the evermap authors
// SPDX-License-Identifier: BSD-3-Clause
#include <algorithm>
#include <array>
#include <bit>
#include <cstring>
#include <stdexcept>

#include <evermap/io/detail/point_table.hpp>

namespace evermap {
namespace {

template <typename T>
void append_little_endian(std::string& bytes, T value) {
  auto raw = std::bit_cast<std::array<char, sizeof(T)>>(value);
  if constexpr (std::endian::native == std::endian::big) std::reverse(raw.begin(), raw.end());
  bytes.append(raw.data(), raw.size());
}

}  // namespace

void PointTable::validate() const {
  if (columns.empty()) throw std::invalid_argument("a point table needs a column");
  for (const Column& column : columns) {
    const bool is_word = std::all_of(column.name.begin(), column.name.end(), [](char c) { return c > ' '; });
    if (column.name.empty() || !is_word) {
      throw std::invalid_argument("'" + column.name + "' cannot name a column: use one word");
    }
  }
  if (values.size() % columns.size() != 0) {
    throw std::invalid_argument("a point table's values must fill whole rows");
  }
}

void write_rows(AtomicFile& file, const PointTable& table) {
  std::string row;
  for (std::size_t i = 0; i < table.values.size();) {
    row.clear();
    for (const PointTable::Column& column : table.columns) {
      const double value = table.values[i++];
      if (column.type == PointTable::Type::kFloat64) {
        append_little_endian(row, value);
      } else {
        append_little_endian(row, static_cast<float>(value));
      }
    }
    file.write(row);
  }
}

}  // namespace evermap
