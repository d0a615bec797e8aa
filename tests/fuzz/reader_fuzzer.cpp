// SPDX-FileCopyrightText: 2026 the evermap authors
// SPDX-License-Identifier: BSD-3-Clause
// libFuzzer over one reader, EVERMAP_READ(path): whatever a file holds, it is read or refused by a FileError.
#include <cstddef>
#include <cstdint>
#include <fstream>
#include <unistd.h>

#include <evermap/bags/scan_bag.hpp>
#include <evermap/files/file_error.hpp>
#include <evermap/io/cloud.hpp>
#include <evermap/io/map_file.hpp>
#include <evermap/io/poses.hpp>

namespace {

[[maybe_unused]] void read_all(const std::filesystem::path& path) {
  const auto scans = evermap::open_scans(path, {.reference = "odom"});
  while (const std::optional<evermap::Scan> scan = scans->next()) scans->pose_at(*scan->time);
}

/// A file in memory with the extension that the reader wants.
const std::filesystem::path& input_file() {
  static const std::filesystem::path path =
      "/dev/shm/evermap-fuzz-" + std::to_string(::getpid()) + EVERMAP_EXTENSION;
  return path;
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  std::ofstream(input_file(), std::ios::binary)
      .write(reinterpret_cast<const char*>(data), static_cast<std::streamsize>(size));
  try {
    EVERMAP_READ(input_file());
  } catch (const evermap::FileError&) {
  }
  return 0;
}
