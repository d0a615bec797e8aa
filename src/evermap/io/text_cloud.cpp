// SPDX-FileCopyrightText: 2026 the evermap authors
// SPDX-License-Identifier: BSD-3-Clause
#include <algorithm>
#include <array>
#include <cmath>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include <evermap/files/detail/input_file.hpp>
#include <evermap/files/detail/text_lines.hpp>
#include <evermap/io/detail/scan_builder.hpp>
#include <evermap/io/detail/text_cloud.hpp>

namespace evermap {
namespace {

std::vector<std::string_view> columns_of(std::string& line) {
  std::replace_if(
      line.begin(), line.end(), [](char c) { return c == ',' || c == ';'; }, ' ');
  std::vector<std::string_view> columns;
  std::string_view rest = line;
  for (std::string_view token = next_token(rest); !token.empty(); token = next_token(rest))
    columns.push_back(token);
  return columns;
}

/// The columns of x, y and z by their names in a header; none when it is no header.
std::optional<std::array<std::size_t, 3>> named_axes(const std::vector<std::string_view>& names) {
  std::array<std::size_t, 3> axes{};
  for (std::size_t axis = 0; axis < 3; ++axis) {
    const auto found = std::find_if(names.begin(), names.end(), [&](std::string_view name) {
      if (name.starts_with('"') && name.ends_with('"') && name.size() > 2)
        name = name.substr(1, name.size() - 2);
      return name.size() == 1 && (name.front() == "xyz"[axis] || name.front() == "XYZ"[axis]);
    });
    if (found == names.end()) return std::nullopt;
    axes[axis] = static_cast<std::size_t>(found - names.begin());
  }
  return axes;
}

}  // namespace

Scan read_text_cloud(const std::filesystem::path& path, CloudNotes* notes) {
  const InputFile file(path);
  TextLines lines(file);
  Scan scan;
  std::array<std::size_t, 3> axes = {0, 1, 2};
  std::size_t columns = 0;
  bool is_first = true;
  std::string line;
  while (lines.next_filled()) {
    line = lines.line();
    std::vector<std::string_view> tokens = columns_of(line);
    const bool was_first = std::exchange(is_first, false);
    const bool is_comment = !tokens.empty() && (tokens[0].starts_with('#') || tokens[0].starts_with("//"));
    if (is_comment && tokens[0].size() <= 2) tokens.erase(tokens.begin());
    if (was_first) {
      if (const auto named = named_axes(tokens)) {
        axes = *named;
        columns = tokens.size();
        continue;
      }
      if (tokens.size() == 1 && parse_count(tokens[0])) continue;
    }
    if (is_comment) {
      is_first = was_first;
      continue;
    }
    if (columns == 0) columns = tokens.size();
    if (tokens.size() != columns || columns < 3) {
      lines.fail("has " + std::to_string(tokens.size()) +
                 " values; a point needs x, y and z, and every line as many "
                 "values as the first");
    }
    Eigen::Vector3d p_sensor;
    for (int axis = 0; axis < 3; ++axis) {
      const std::string_view token = tokens[axes[static_cast<std::size_t>(axis)]];
      const std::optional<double> value = parse_number(token);
      if (!value)
        lines.fail("holds " + in_quotes(token) + " where a coordinate should be; correct or remove the line");
      p_sensor[axis] = *value;
    }
    add_point(scan, p_sensor);
  }
  if (notes != nullptr) notes->farthest_coordinate = farthest_coordinate(scan);
  return scan;
}

}  // namespace evermap
