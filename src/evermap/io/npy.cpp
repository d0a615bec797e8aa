// SPDX-FileCopyrightText: 2026 the evermap authors
// SPDX-License-Identifier: BSD-3-Clause
#include <algorithm>
#include <array>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include <evermap/files/detail/input_file.hpp>
#include <evermap/files/detail/record_layout.hpp>
#include <evermap/files/detail/text_lines.hpp>
#include <evermap/io/detail/npy.hpp>
#include <evermap/io/detail/scan_builder.hpp>

namespace evermap {
namespace {

constexpr std::string_view kNpyMagic("\x93NUMPY", 6);

struct Type {
  std::string_view code;
  Scalar scalar;
};
constexpr std::array<Type, 10> kTypes = {{{"i1", Scalar::kInt8},
                                          {"u1", Scalar::kUint8},
                                          {"i2", Scalar::kInt16},
                                          {"u2", Scalar::kUint16},
                                          {"i4", Scalar::kInt32},
                                          {"u4", Scalar::kUint32},
                                          {"i8", Scalar::kInt64},
                                          {"u8", Scalar::kUint64},
                                          {"f4", Scalar::kFloat32},
                                          {"f8", Scalar::kFloat64}}};

/// What numbers() of the header say, without blanks.
struct NpyHeader {
  std::string text;
  std::size_t data;  ///< [bytes] where it begins
};

NpyHeader read_header(const InputFile& file) {
  const std::string_view bytes = file.bytes();
  if (!bytes.starts_with(kNpyMagic)) file.fail("is no array of NumPy; save it by numpy.save");
  const bool is_first = bytes.size() > kNpyMagic.size() && bytes[kNpyMagic.size()] == 1;
  const std::size_t begin = kNpyMagic.size() + 2 + (is_first ? 2 : 4);
  if (bytes.size() < begin) file.fail("ends inside its header; copy the file again");
  const auto size =
      static_cast<std::size_t>(decode(bytes.data() + kNpyMagic.size() + 2,
                                      is_first ? Scalar::kUint16 : Scalar::kUint32, std::endian::little));
  if (size > bytes.size() - begin) file.fail("ends inside its header; copy the file again");
  NpyHeader header{"", begin + size};
  for (const char c : bytes.substr(begin, size)) {
    if (c != ' ' && c != '\n' && c != '"') header.text += c;
  }
  return header;
}

/// What stands behind `key` up to the bracket that closes, or to the next comma.
std::string_view value_of(std::string_view header, std::string_view key) {
  std::string quoted = "'";
  quoted += key;
  quoted += "':";
  const std::size_t found = header.find(quoted);
  if (found == std::string_view::npos) return {};
  const std::string_view rest = header.substr(found + quoted.size());
  int depth = 0;
  std::size_t size = 0;
  for (; size < rest.size(); ++size) {
    const char c = rest[size];
    if (depth == 0 && (c == ',' || c == '}')) break;
    if (c == '(' || c == '[') ++depth;
    if (c == ')' || c == ']') --depth;
  }
  return rest.substr(0, size);
}

std::string_view unquoted(std::string_view text) {
  if (text.starts_with('\'')) text.remove_prefix(1);
  if (text.ends_with('\'')) text.remove_suffix(1);
  return text;
}

/// The type of a code such as '<f4', whose byte order must be that of the others.
std::optional<Scalar> type_of(std::string_view code, std::endian& order) {
  code = unquoted(code);
  if (code.empty()) return std::nullopt;
  if (code.front() == '>') order = std::endian::big;
  if (code.front() == '<' || code.front() == '>' || code.front() == '|' || code.front() == '=')
    code.remove_prefix(1);
  const auto* found =
      std::find_if(kTypes.begin(), kTypes.end(), [&](const Type& type) { return type.code == code; });
  if (found == kTypes.end()) return std::nullopt;
  return found->scalar;
}

/// Cuts what stands before the next `end` off the front.
std::string_view take_until(std::string_view& rest, char end) {
  const std::size_t size = std::min(rest.find(end), rest.size());
  const std::string_view taken = rest.substr(0, size);
  rest.remove_prefix(std::min(size + 1, rest.size()));
  return taken;
}

/// Of [('x','<f4'),('y','<f4'),...].
std::optional<RecordLayout> record_layout_of(std::string_view descr, std::endian& order) {
  RecordLayout layout;
  take_until(descr, '(');
  while (!descr.empty()) {
    std::string_view field = take_until(descr, ')');
    const std::string_view name = unquoted(take_until(field, ','));
    const std::optional<Scalar> type = type_of(take_until(field, ','), order);
    if (!type || !field.empty() || !layout.append(std::string(name), *type, 1)) return std::nullopt;
    take_until(descr, '(');
  }
  return layout;
}

std::optional<std::vector<std::uint64_t>> shape_of(std::string_view shape) {
  std::vector<std::uint64_t> sizes;
  if (!shape.starts_with('(') || !shape.ends_with(')')) return std::nullopt;
  shape = shape.substr(1, shape.size() - 2);
  while (!shape.empty()) {
    const std::optional<std::uint64_t> size = parse_count(take_until(shape, ','));
    if (!size || *size > RecordLayout::kMaxStride) return std::nullopt;
    sizes.push_back(*size);
  }
  return sizes;
}

}  // namespace

Scan read_npy(const std::filesystem::path& path, CloudNotes* notes) {
  constexpr const char* kExpected =
      "is no array of points; evermap reads numbers of shape (points, 3 or more), or records with x, y and z";
  const InputFile file(path);
  const NpyHeader header = read_header(file);
  const std::string_view descr = value_of(header.text, "descr");
  const std::optional<std::vector<std::uint64_t>> shape = shape_of(value_of(header.text, "shape"));
  const bool is_by_column = value_of(header.text, "fortran_order") == "True";
  const bool has_records = descr.starts_with('[');
  if (!shape || shape->empty() || shape->size() > 3 || (is_by_column && shape->size() != 2))
    file.fail(kExpected);
  std::endian order = std::endian::little;
  RecordLayout layout;
  std::uint64_t points = 1;
  const std::size_t rows = has_records ? shape->size() : shape->size() - 1;
  for (std::size_t i = 0; i < rows; ++i) points *= (*shape)[i];
  if (has_records) {
    std::optional<RecordLayout> records = record_layout_of(descr, order);
    if (!records || is_by_column) file.fail(kExpected);
    layout = std::move(*records);
  } else {
    const std::optional<Scalar> type = type_of(descr, order);
    const std::uint64_t values = shape->back();
    if (!type || shape->size() < 2 || values < 3) file.fail(kExpected);
    for (const char* axis : {"x", "y", "z"}) {
      if (!layout.append(axis, *type, 1)) file.fail(kExpected);
    }
    for (std::uint64_t i = 3; i < values; ++i) {
      if (!layout.append("other", *type, 1)) file.fail(kExpected);
    }
  }
  ScanBuilder builder(path, layout);
  const std::string_view data = file.bytes().substr(header.data);
  if (is_by_column) {
    if (order == std::endian::big) file.fail("is by columns and big endian; save it by rows");
    if (points > data.size() / layout.stride()) file.fail("ends inside its values; copy the file again");
    builder.add_columns(data.data(), points);
  } else {
    builder.add_records(data, header.data, points, order);
  }
  return builder.finish(notes);
}

}  // namespace evermap
