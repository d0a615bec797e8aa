// SPDX-FileCopyrightText: 2026 the evermap authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <string>

#include "files/file_fixture.hpp"

namespace evermap {

/// A PCD header for points of three float32 coordinates.
inline std::string pcd_header(std::size_t points, const std::string& data) {
  const std::string count = std::to_string(points);
  return "# .PCD v0.7\nVERSION 0.7\nFIELDS x y z\nSIZE 4 4 4\nTYPE F F F\nCOUNT 1 1 1\nWIDTH " + count +
         "\nHEIGHT 1\nVIEWPOINT 0 0 0 1 0 0 0\nPOINTS " + count + "\nDATA " + data + "\n";
}

/// `bytes` as an LZF stream of literals only.
inline std::string lzf_literals(const std::string& bytes) {
  std::string stream;
  for (std::size_t i = 0; i < bytes.size(); i += 32) {
    const std::string run = bytes.substr(i, 32);
    stream += static_cast<char>(run.size() - 1);
    stream += run;
  }
  return stream;
}

/// What follows the header of a binary_compressed PCD file.
inline std::string compressed_block(const std::string& columns) {
  const std::string stream = lzf_literals(columns);
  return bytes_of<std::uint32_t>(
             {static_cast<std::uint32_t>(stream.size()), static_cast<std::uint32_t>(columns.size())}) +
         stream;
}

/// A small file of every format and encoding, three points each.
struct Sample {
  std::string name;
  std::string bytes;
  bool has_text_points = false;  ///< a shorter last number is still a number
};

inline std::vector<Sample> samples() {
  const std::vector<float> rows = {1, 2, 3, 4, 5, 6, 7, 8, 9};
  const std::string columns = bytes_of<float>({1, 4, 7, 2, 5, 8, 3, 6, 9});
  const std::string vertex = "element vertex 3\nproperty float x\nproperty float y\nproperty float z\n";
  const std::string face = "element face 1\nproperty list uchar int vertex_indices\n";
  const auto ply = [&](const std::string& format) {
    return "ply\nformat " + format + " 1.0\ncomment by hand\n" + face + vertex + "end_header\n";
  };
  const auto indices = [](std::endian order) {
    return std::string("\x03") + bytes_of<std::int32_t>({0, 1, 2}, order);
  };
  return {
      {"a.bin", bytes_of<float>({1, 2, 3, 0, 4, 5, 6, 0, 7, 8, 9, 0})},
      {"ascii.pcd", pcd_header(3, "ascii") + "1 2 3\n4 5 6\n7 8 9\n", true},
      {"binary.pcd", pcd_header(3, "binary") + bytes_of(rows)},
      {"compressed.pcd", pcd_header(3, "binary_compressed") + compressed_block(columns)},
      {"ascii.ply", ply("ascii") + "3 0 1 2\n1 2 3\n4 5 6\n7 8 9\n", true},
      {"little.ply", ply("binary_little_endian") + indices(std::endian::little) + bytes_of(rows)},
      {"big.ply", ply("binary_big_endian") + indices(std::endian::big) + bytes_of(rows, std::endian::big)}};
}

}  // namespace evermap
