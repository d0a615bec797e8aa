// SPDX-FileCopyrightText: 2026 the evermap authors
// SPDX-License-Identifier: BSD-3-Clause
#include <string>

#include <evermap/io/ply.hpp>
#include <evermap/io/ply_header.hpp>
#include <evermap/io/scan_builder.hpp>

namespace evermap {
namespace {

RecordLayout layout_of(const PlyElement& element, const InputFile& file) {
  RecordLayout layout;
  for (const PlyProperty& property : element.properties) {
    if (property.list_count_type) {
      file.fail("the vertices have a list, " + in_quotes(property.name) + "; write the file without it");
    }
    if (!layout.append(property.name, property.type, 1)) file.fail("has too many properties");
  }
  return layout;
}

/// Steps over binary elements that stand before the vertices. Every step is checked against the file's end.
class BinarySkipper {
 public:
  BinarySkipper(const InputFile& file, std::size_t offset, std::endian order)
      : file_(file), offset_(offset), order_(order) {}

  std::size_t offset() const { return offset_; }

  void skip(const PlyElement& element) {
    if (element.has_list()) {
      for (std::uint64_t i = 0; i < element.count; ++i) skip_one(element);
      return;
    }
    std::size_t stride = 0;
    for (const PlyProperty& property : element.properties) stride += size_of(property.type);
    advance(element.count, stride);
  }

 private:
  void skip_one(const PlyElement& element) {
    for (const PlyProperty& property : element.properties) {
      std::uint64_t count = 1;
      if (property.list_count_type) {
        const std::size_t at = offset_;
        advance(1, size_of(*property.list_count_type));
        const double length = decode(file_.bytes().data() + at, *property.list_count_type, order_);
        if (length < 0) file_.fail_at_byte(at, "a list of negative length; write the file again");
        count = static_cast<std::uint64_t>(length);
      }
      advance(count, size_of(property.type));
    }
  }

  void advance(std::uint64_t count, std::size_t size) {
    if (size == 0) return;
    if (count > (file_.bytes().size() - offset_) / size) {
      file_.fail_at_byte(offset_, "the file ends inside the data before its vertices; copy it again");
    }
    offset_ += count * size;
  }

  const InputFile& file_;
  std::size_t offset_;  ///< [bytes] of what is not yet skipped, at most the file's size
  std::endian order_;
};

void skip_lines(TextLines& lines, const PlyElement& element) {
  if (element.properties.empty()) return;
  for (std::uint64_t i = 0; i < element.count; ++i) {
    if (!lines.next_filled()) lines.fail("the file ends before its vertices; copy it again");
  }
}

}  // namespace

Scan read_ply(const std::filesystem::path& path) {
  const InputFile file(path);
  TextLines lines(file);
  const PlyHeader header = read_ply_header(file, lines);
  const bool is_ascii = header.encoding == PlyEncoding::kAscii;
  const std::endian order =
      header.encoding == PlyEncoding::kBinaryBigEndian ? std::endian::big : std::endian::little;
  BinarySkipper skipper(file, lines.offset(), order);
  for (const PlyElement& element : header.elements) {
    if (element.name == "vertex") {
      const RecordLayout layout = layout_of(element, file);
      ScanBuilder builder(file, layout);
      if (is_ascii) {
        builder.add_lines(lines, element.count);
      } else {
        builder.add_records(skipper.offset(), element.count, order);
      }
      return builder.finish();
    }
    if (is_ascii) {
      skip_lines(lines, element);
    } else {
      skipper.skip(element);
    }
  }
  file.fail("has no vertex element; a point cloud needs one");
}

void write_ply(const std::filesystem::path& path, const PointTable& table) {
  table.validate();
  AtomicFile file(path);
  file.write("ply\nformat binary_little_endian 1.0\nelement vertex " + std::to_string(table.rows()) + "\n");
  for (const PointTable::Column& column : table.columns) {
    const bool is_double = column.type == PointTable::Type::kFloat64;
    file.write((is_double ? "property double " : "property float ") + column.name + "\n");
  }
  file.write("end_header\n");
  write_rows(file, table);
  file.commit();
}

}  // namespace evermap
