// SPDX-FileCopyrightText: 2026 the evermap authors
// SPDX-License-Identifier: BSD-3-Clause
#include <algorithm>
#include <array>
#include <string_view>

#include <evermap/files/detail/ply_header.hpp>

namespace evermap {
namespace {

Scalar scalar_from(std::string_view name, const TextLines& lines) {
  struct Name {
    std::string_view classic, sized;
    Scalar scalar;
  };
  constexpr std::array<Name, 8> kNames = {{{"char", "int8", Scalar::kInt8},
                                           {"uchar", "uint8", Scalar::kUint8},
                                           {"short", "int16", Scalar::kInt16},
                                           {"ushort", "uint16", Scalar::kUint16},
                                           {"int", "int32", Scalar::kInt32},
                                           {"uint", "uint32", Scalar::kUint32},
                                           {"float", "float32", Scalar::kFloat32},
                                           {"double", "float64", Scalar::kFloat64}}};
  for (const Name& known : kNames) {
    if (known.classic == name || known.sized == name) return known.scalar;
  }
  lines.fail(in_quotes(name) +
             " is no type of a PLY property; known are char uchar short ushort int uint float double");
}

PlyEncoding encoding_from(std::string_view rest, const TextLines& lines) {
  const std::string_view name = next_token(rest);
  if (next_token(rest) != "1.0") lines.fail("the version of a PLY file must be 1.0");
  if (name == "ascii") return PlyEncoding::kAscii;
  if (name == "binary_little_endian") return PlyEncoding::kBinaryLittleEndian;
  if (name == "binary_big_endian") return PlyEncoding::kBinaryBigEndian;
  lines.fail(in_quotes(name) + " is no PLY format; known are ascii, binary_little_endian, binary_big_endian");
}

PlyElement element_from(std::string_view rest, const TextLines& lines) {
  const std::string_view name = next_token(rest);
  const std::string_view count = next_token(rest);
  const std::optional<std::uint64_t> value = parse_count(count);
  if (!value) lines.fail(in_quotes(count) + " is no count of elements (0, 1, 2, ...)");
  return {std::string(name), *value, {}};
}

PlyProperty property_from(std::string_view rest, const TextLines& lines) {
  PlyProperty property{};
  std::string_view type = next_token(rest);
  if (type == "list") {
    const std::string_view count_type = next_token(rest);
    property.list_count_type = scalar_from(count_type, lines);
    if (is_floating(*property.list_count_type)) {
      lines.fail(in_quotes(count_type) + " cannot count a list's values; use an integer type");
    }
    type = next_token(rest);
  }
  property.type = scalar_from(type, lines);
  property.name = next_token(rest);
  if (property.name.empty()) lines.fail("a property without a name");
  return property;
}

}  // namespace

bool PlyElement::has_list() const {
  return std::any_of(properties.begin(), properties.end(),
                     [](const PlyProperty& property) { return property.list_count_type.has_value(); });
}

PlyHeader read_ply_header(const InputFile& file, TextLines& lines) {
  if (!lines.next() || lines.line() != "ply")
    file.fail_at_byte(0, "does not begin with 'ply'; is this a PLY file?");
  PlyHeader header;
  std::optional<PlyEncoding> encoding;
  while (lines.next()) {
    std::string_view rest = lines.line();
    const std::string_view keyword = next_token(rest);
    if (keyword == "format") {
      encoding = encoding_from(rest, lines);
    } else if (keyword == "element") {
      header.elements.push_back(element_from(rest, lines));
    } else if (keyword == "property") {
      if (header.elements.empty()) lines.fail("a property before the first element");
      header.elements.back().properties.push_back(property_from(rest, lines));
    } else if (keyword == "end_header") {
      if (!encoding) lines.fail("the header has no format line; add it");
      header.encoding = *encoding;
      return header;
    } else if (keyword != "comment" && keyword != "obj_info" && !keyword.empty()) {
      lines.fail(in_quotes(keyword) + " is no keyword of a PLY header");
    }
  }
  file.fail_at_byte(file.bytes().size(),
                    "ends before the end_header line of its PLY header; copy the file again");
}

}  // namespace evermap
