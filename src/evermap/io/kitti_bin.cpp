// SPDX-FileCopyrightText: 2026 the evermap authors
// SPDX-License-Identifier: BSD-3-Clause
#include <evermap/io/kitti_bin.hpp>
#include <evermap/io/scan_builder.hpp>

namespace evermap {
namespace {

constexpr std::size_t kPointSize = 4 * sizeof(float);  // [bytes]

}  // namespace

Scan read_kitti_bin(const std::filesystem::path& path) {
  const InputFile file(path);
  RecordLayout layout;
  for (const char* name : {"x", "y", "z", "intensity"}) {
    if (!layout.append(name, Scalar::kFloat32, 1)) file.fail("cannot be read as points");
  }
  const std::size_t incomplete = file.bytes().size() % kPointSize;
  if (incomplete != 0) {
    file.fail_at_byte(file.bytes().size() - incomplete, "the last point has " + std::to_string(incomplete) +
                                                            " of " + std::to_string(kPointSize) +
                                                            " bytes; copy the file again");
  }
  ScanBuilder builder(file, layout);
  builder.add_records(0, file.bytes().size() / kPointSize, std::endian::little);
  return builder.finish();
}

}  // namespace evermap
