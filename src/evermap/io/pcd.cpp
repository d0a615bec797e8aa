// SPDX-FileCopyrightText: 2026 the evermap authors
// SPDX-License-Identifier: BSD-3-Clause
#include <string>

#include <evermap/files/detail/expansion.hpp>
#include <evermap/io/detail/lzf.hpp>
#include <evermap/io/detail/pcd.hpp>
#include <evermap/io/detail/pcd_header.hpp>
#include <evermap/io/detail/scan_builder.hpp>

namespace evermap {
namespace {

constexpr std::uint64_t kMemoryOfPoint = sizeof(Eigen::Vector3d) + sizeof(double) + sizeof(float);  // [bytes]

/// Two sizes [bytes], uint32 each, then the LZF stream of the columns.
void add_compressed(ScanBuilder& builder, const InputFile& file, const PcdHeader& header,
                    std::size_t offset) {
  if (header.points == 0) return;
  const std::string_view rest = file.bytes().substr(offset);
  if (rest.size() < 8) file.fail_at_byte(offset, "ends inside the sizes of its data; copy the file again");
  const auto size_at = [&](std::size_t i) {
    return static_cast<std::size_t>(decode(rest.data() + i, Scalar::kUint32, std::endian::little));
  };
  const std::size_t compressed_size = size_at(0);
  const std::size_t size = size_at(4);
  if (compressed_size > rest.size() - 8) {
    file.fail_at_byte(offset, "promises " + std::to_string(compressed_size) + " compressed bytes, " +
                                  std::to_string(rest.size() - 8) + " follow; copy the file again");
  }
  const std::size_t stride = header.layout.stride();
  if (size % stride != 0 || size / stride != header.points) {
    file.fail_at_byte(offset + 4, "promises " + std::to_string(size) + " bytes uncompressed, but " +
                                      std::to_string(header.points) + " points of " + std::to_string(stride) +
                                      " bytes are another number; write the file again");
  }
  if (size / kLzfMaxRatio > compressed_size) {
    file.fail_at_byte(offset + 4, "promises more data than " + std::to_string(compressed_size) +
                                      " compressed bytes can hold; write the file again");
  }
  const std::uint64_t memory = header.points * kMemoryOfPoint;
  if (memory > greatest_expansion(file.bytes().size())) {
    file.fail_at_byte(offset + 4, "expands to " + std::to_string(header.points) +
                                      " points, more than a file of " + std::to_string(file.bytes().size()) +
                                      " bytes may; write it uncompressed (DATA binary)");
  }
  std::string columns(size, '\0');
  const std::optional<std::size_t> damage = lzf_decompress(rest.substr(8, compressed_size), columns);
  if (damage) {
    file.fail_at_byte(offset + 8 + *damage, "the compressed data is damaged; copy or write the file again");
  }
  builder.add_columns(columns.data(), header.points);
}

}  // namespace

Scan read_pcd(const std::filesystem::path& path, CloudNotes* notes) {
  const InputFile file(path);
  TextLines lines(file);
  const PcdHeader header = read_pcd_header(file, lines);
  ScanBuilder builder(path, header.layout);
  switch (header.encoding) {
    case PcdEncoding::kAscii:
      builder.add_lines(lines, header.points);
      if (lines.next_filled()) lines.fail("more points than the header says; correct WIDTH and POINTS");
      break;
    case PcdEncoding::kBinary:
      builder.add_records(file.bytes().substr(lines.offset()), lines.offset(), header.points,
                          std::endian::little);
      break;
    case PcdEncoding::kBinaryCompressed:
      add_compressed(builder, file, header, lines.offset());
      break;
  }
  Scan scan = builder.finish(notes);
  scan.T_map_sensor = header.T_map_sensor;
  if (notes != nullptr) notes->has_viewpoint = header.T_map_sensor.has_value();
  return scan;
}

void write_pcd(const std::filesystem::path& path, const PointTable& table) {
  table.validate();
  std::string fields, sizes, types, counts;
  for (const PointTable::Column& column : table.columns) {
    fields += " " + column.name;
    sizes += column.type == PointTable::Type::kFloat64 ? " 8" : " 4";
    types += " F";
    counts += " 1";
  }
  const std::string rows = std::to_string(table.rows());
  AtomicFile file(path);
  file.write("# .PCD v0.7 - Point Cloud Data file format\nVERSION 0.7\nFIELDS" + fields + "\nSIZE" + sizes +
             "\nTYPE" + types + "\nCOUNT" + counts + "\nWIDTH " + rows +
             "\nHEIGHT 1\nVIEWPOINT 0 0 0 1 0 0 0\nPOINTS " + rows + "\nDATA binary\n");
  write_rows(file, table);
  file.commit();
}

}  // namespace evermap
