// SPDX-FileCopyrightText: 2026 the evermap authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstddef>
#include <filesystem>
#include <optional>
#include <vector>

#include <evermap/scan/scan.hpp>

namespace evermap {

/// A sequence of scans, read one at a time: a folder of .bin, .pcd or .ply files in the order of their names
/// (one format per folder), or one such file. The constructor throws FileError when there is no scan in it or
/// the formats are mixed; files of other kinds and hidden ones are ignored. Not thread safe.
class ScanSource {
 public:
  explicit ScanSource(const std::filesystem::path& path);

  std::size_t size() const { return files_.size(); }
  const std::filesystem::path& file(std::size_t index) const { return files_[index]; }
  /// The next scan, none after the last. Throws FileError when its file is damaged.
  std::optional<Scan> next();

 private:
  std::vector<std::filesystem::path> files_;
  std::size_t position_ = 0;
};

}  // namespace evermap
