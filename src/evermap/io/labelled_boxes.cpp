// SPDX-FileCopyrightText: 2026 the evermap authors
// SPDX-License-Identifier: BSD-3-Clause
#include <algorithm>
#include <array>
#include <cmath>
#include <string>
#include <string_view>

#include <evermap/files/detail/text_lines.hpp>
#include <evermap/io/detail/labelled_boxes.hpp>

namespace evermap {
namespace {

constexpr std::array<std::string_view, 9> kColumns = {"frame", "x",      "y",   "z",     "length",
                                                      "width", "height", "yaw", "moving"};
constexpr double kMaxFrame = 1e6;  // bounds the memory that one wrong number can ask for

std::vector<std::string_view> split_at_commas(std::string_view line) {
  std::vector<std::string_view> cells;
  for (std::size_t begin = 0; begin <= line.size();) {
    const std::size_t end = std::min(line.find(',', begin), line.size());
    cells.push_back(line.substr(begin, end - begin));
    begin = end + 1;
  }
  return cells;
}

/// Where each of kColumns stands in the header line.
std::array<std::size_t, kColumns.size()> find_columns(const TextLines& lines) {
  const auto header = split_at_commas(lines.line());
  std::array<std::size_t, kColumns.size()> places{};
  for (std::size_t i = 0; i < kColumns.size(); ++i) {
    const auto found = std::find(header.begin(), header.end(), kColumns[i]);
    if (found == header.end()) lines.fail("there is no column '" + std::string(kColumns[i]) + "'; add it");
    places[i] = static_cast<std::size_t>(found - header.begin());
  }
  return places;
}

std::array<double, kColumns.size()> read_row(const TextLines& lines,
                                             const std::array<std::size_t, kColumns.size()>& places) {
  const auto cells = split_at_commas(lines.line());
  std::array<double, kColumns.size()> row{};
  for (std::size_t i = 0; i < kColumns.size(); ++i) {
    const auto value = places[i] < cells.size() ? parse_number(cells[places[i]]) : std::nullopt;
    if (!value || !std::isfinite(*value)) {
      lines.fail("column '" + std::string(kColumns[i]) + "' holds no number; correct it");
    }
    row[i] = *value;
  }
  return row;
}

}  // namespace

std::vector<std::vector<LabelledBox>> read_labelled_boxes(const std::filesystem::path& path) {
  const InputFile file(path);
  TextLines lines(file);
  if (!lines.next_filled()) file.fail("holds no header line");
  const auto places = find_columns(lines);
  std::vector<std::vector<LabelledBox>> frames;
  while (lines.next_filled()) {
    const auto [frame, x, y, z, length, width, height, yaw, moving] = read_row(lines, places);
    if (frame < 0 || frame > kMaxFrame || frame != std::floor(frame))
      lines.fail("the frame is no scan's number");
    if (std::min({length, width, height}) < 0) lines.fail("a box has a negative size");
    if (moving != -1 && moving != 0 && moving != 1) lines.fail("moving must be -1 (uncertain), 0 or 1");
    frames.resize(std::max(frames.size(), static_cast<std::size_t>(frame) + 1));
    frames[static_cast<std::size_t>(frame)].push_back(
        {{x, y, z},
         {length, width, height},
         yaw,
         static_cast<LabelledBox::Motion>(static_cast<int>(moving))});
  }
  return frames;
}

}  // namespace evermap
