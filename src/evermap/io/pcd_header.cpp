// SPDX-FileCopyrightText: 2026 the evermap authors
// SPDX-License-Identifier: BSD-3-Clause
#include <algorithm>
#include <array>
#include <cmath>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include <evermap/io/detail/pcd_header.hpp>
#include <evermap/io/detail/quaternion.hpp>

namespace evermap {
namespace {

/// The tokens that follow a keyword; `line` is 0 when the header has no such line.
struct Entry {
  std::string_view keyword;
  std::uint64_t line = 0;
  std::vector<std::string_view> tokens = {};
};

/// The header's lines by keyword, before anything is made of their values.
class Entries {
 public:
  Entries(const InputFile& file, TextLines& lines);

  const Entry& find(std::string_view keyword) const {
    return *std::find_if(entries_.begin(), entries_.end(),
                         [&](const Entry& e) { return e.keyword == keyword; });
  }
  const Entry& require(std::string_view keyword) const {
    const Entry& entry = find(keyword);
    if (entry.line == 0) file_.fail("has no " + std::string(keyword) + " line in its PCD header; add it");
    return entry;
  }
  /// The count that stands alone behind `keyword`; none when there is no such line.
  std::optional<std::uint64_t> count(std::string_view keyword) const;

  [[noreturn]] void fail(const Entry& entry, const std::string& message) const {
    file_.fail_at_line(entry.line, std::string(entry.keyword) + " " + message);
  }

 private:
  void add(TextLines& lines, std::string_view keyword, std::string_view rest);

  const InputFile& file_;
  std::array<Entry, 10> entries_ = {{{"VERSION"},
                                     {"FIELDS"},
                                     {"SIZE"},
                                     {"TYPE"},
                                     {"COUNT"},
                                     {"WIDTH"},
                                     {"HEIGHT"},
                                     {"VIEWPOINT"},
                                     {"POINTS"},
                                     {"DATA"}}};
};

Entries::Entries(const InputFile& file, TextLines& lines) : file_(file) {
  while (lines.next_filled()) {
    std::string_view rest = lines.line();
    const std::string_view keyword = next_token(rest);
    if (keyword.starts_with('#')) continue;
    add(lines, keyword == "COLUMNS" ? "FIELDS" : keyword, rest);  // the name of FIELDS before version 0.7
    if (keyword == "DATA") return;
  }
  file.fail_at_byte(file.bytes().size(), "ends before the DATA line of its PCD header; copy the file again");
}

void Entries::add(TextLines& lines, std::string_view keyword, std::string_view rest) {
  const auto entry = std::find_if(entries_.begin(), entries_.end(),
                                  [&](const Entry& known) { return known.keyword == keyword; });
  if (entry == entries_.end()) {
    lines.fail(in_quotes(keyword) + " is no keyword of a PCD header; is this a PCD file?");
  }
  if (entry->line != 0) {
    lines.fail("a second " + std::string(keyword) + " line; the first is line " +
               std::to_string(entry->line));
  }
  entry->line = lines.number();
  for (std::string_view token = next_token(rest); !token.empty(); token = next_token(rest)) {
    entry->tokens.push_back(token);
  }
}

std::optional<std::uint64_t> Entries::count(std::string_view keyword) const {
  const Entry& entry = find(keyword);
  if (entry.line == 0) return std::nullopt;
  if (entry.tokens.size() != 1) fail(entry, "needs one number");
  const std::optional<std::uint64_t> value = parse_count(entry.tokens[0]);
  if (!value) fail(entry, in_quotes(entry.tokens[0]) + " is no count (0, 1, 2, ...)");
  return value;
}

std::optional<Scalar> scalar_from(std::string_view type, std::string_view size) {
  struct Name {
    std::string_view type, size;
    Scalar scalar;
  };
  constexpr std::array<Name, 10> kNames = {{{"I", "1", Scalar::kInt8},
                                            {"U", "1", Scalar::kUint8},
                                            {"I", "2", Scalar::kInt16},
                                            {"U", "2", Scalar::kUint16},
                                            {"I", "4", Scalar::kInt32},
                                            {"U", "4", Scalar::kUint32},
                                            {"I", "8", Scalar::kInt64},
                                            {"U", "8", Scalar::kUint64},
                                            {"F", "4", Scalar::kFloat32},
                                            {"F", "8", Scalar::kFloat64}}};
  for (const Name& name : kNames) {
    if (name.type == type && name.size == size) return name.scalar;
  }
  return std::nullopt;
}

RecordLayout layout_from(const Entries& entries) {
  const Entry& names = entries.require("FIELDS");
  const Entry& sizes = entries.require("SIZE");
  const Entry& types = entries.require("TYPE");
  const Entry& counts = entries.find("COUNT");  // may be missing: then every field is one value
  for (const Entry* entry : {&sizes, &types, &counts}) {
    if (entry->line != 0 && entry->tokens.size() != names.tokens.size()) {
      entries.fail(*entry, "has " + std::to_string(entry->tokens.size()) + " values for " +
                               std::to_string(names.tokens.size()) + " FIELDS; give one each");
    }
  }
  RecordLayout layout;
  for (std::size_t i = 0; i < names.tokens.size(); ++i) {
    const std::optional<Scalar> type = scalar_from(types.tokens[i], sizes.tokens[i]);
    if (!type) {
      entries.fail(types, in_quotes(types.tokens[i]) + " of SIZE " + in_quotes(sizes.tokens[i]) +
                              " is no type; known are I and U of 1, 2, 4, 8 bytes and F of 4, 8");
    }
    const std::optional<std::uint64_t> count = counts.line == 0 ? 1 : parse_count(counts.tokens[i]);
    if (!count) entries.fail(counts, in_quotes(counts.tokens[i]) + " is no number of values (0, 1, 2, ...)");
    if (*count == 0) continue;  // a field that takes no place, as some writers leave behind
    if (!layout.append(std::string(names.tokens[i]), *type, *count)) {
      entries.fail(counts.line == 0 ? names : counts, "makes a point larger than any file; correct it");
    }
  }
  return layout;
}

std::uint64_t points_from(const Entries& entries) {
  const std::optional<std::uint64_t> width = entries.count("WIDTH");
  const std::uint64_t height = entries.count("HEIGHT").value_or(1);
  const std::optional<std::uint64_t> points = entries.count("POINTS");
  if (!width) {
    entries.require("POINTS");
    return *points;
  }
  std::uint64_t product = 0;
  const bool overflows = __builtin_mul_overflow(*width, height, &product);
  if (overflows || (points && product != *points)) {
    entries.fail(entries.find(points ? "POINTS" : "WIDTH"),
                 "does not agree: WIDTH " + std::to_string(*width) + " times HEIGHT " +
                     std::to_string(height) + " must be the number of points");
  }
  return product;
}

std::optional<Pose> viewpoint_from(const Entries& entries) {
  const Entry& entry = entries.find("VIEWPOINT");
  if (entry.line == 0) return std::nullopt;
  if (entry.tokens.size() != 7) entries.fail(entry, "needs seven numbers: tx ty tz qw qx qy qz");
  std::array<double, 7> v;
  for (std::size_t i = 0; i < v.size(); ++i) {
    const std::optional<double> value = parse_number(entry.tokens[i]);
    if (!value || !std::isfinite(*value))
      entries.fail(entry, in_quotes(entry.tokens[i]) + " is no finite number");
    v[i] = *value;
  }
  if (v == std::array<double, 7>{0, 0, 0, 1, 0, 0, 0}) return std::nullopt;
  const std::optional<Eigen::Matrix3d> rotation = rotation_from_file({v[3], v[4], v[5], v[6]});
  if (!rotation)
    entries.fail(entry, "has a quaternion qw qx qy qz whose norm is not 1; without rotation: 1 0 0 0");
  return Pose{*rotation, {v[0], v[1], v[2]}};
}

PcdEncoding encoding_from(const Entries& entries) {
  const Entry& entry = entries.require("DATA");
  if (entry.tokens.size() == 1) {
    if (entry.tokens[0] == "ascii") return PcdEncoding::kAscii;
    if (entry.tokens[0] == "binary") return PcdEncoding::kBinary;
    if (entry.tokens[0] == "binary_compressed") return PcdEncoding::kBinaryCompressed;
  }
  entries.fail(entry, "must be ascii, binary or binary_compressed");
}

}  // namespace

PcdHeader read_pcd_header(const InputFile& file, TextLines& lines) {
  const Entries entries(file, lines);
  return {layout_from(entries), points_from(entries), viewpoint_from(entries), encoding_from(entries)};
}

}  // namespace evermap
