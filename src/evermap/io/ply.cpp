// SPDX-FileCopyrightText: 2026 the evermap authors
// SPDX-License-Identifier: BSD-3-Clause
#include <string>

#include <evermap/files/detail/ply_reader.hpp>
#include <evermap/io/detail/ply.hpp>
#include <evermap/io/detail/scan_builder.hpp>

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

}  // namespace

Scan read_ply(const std::filesystem::path& path, CloudNotes* notes) {
  const InputFile file(path);
  PlyReader ply(file);
  for (const PlyElement& element : ply.elements()) {
    if (element.name != "vertex") {
      ply.skip(element);
      continue;
    }
    const RecordLayout layout = layout_of(element, file);
    ScanBuilder builder(path, layout);
    if (ply.is_ascii()) {
      builder.add_lines(ply.lines(), element.count);
    } else {
      builder.add_records(file.bytes().substr(ply.offset()), ply.offset(), element.count, ply.order());
    }
    return builder.finish(notes);
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
