// SPDX-FileCopyrightText: 2026 the evermap authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <filesystem>
#include <vector>

#include <evermap/io/cloud.hpp>
#include <evermap/io/scan_source.hpp>

namespace evermap {

/// A folder of clouds in the order of their names (see files_in), one format a folder, or one such file. The
/// constructor throws FileError when there is no scan in it or the formats are mixed; files of other kinds
/// are ignored, and texts beside clouds that are none.
class ScanFolder : public ScanSource {
 public:
  explicit ScanFolder(const std::filesystem::path& path, const CloudOptions& options = {});

  std::optional<Scan> next() override;
  std::size_t size() const override { return files_.size(); }
  std::size_t index() const override { return position_ - 1; }
  std::string place() const override { return files_[index()].string(); }
  const CloudNotes& notes() const override { return notes_; }

  const std::filesystem::path& file(std::size_t index) const { return files_[index]; }

 private:
  CloudOptions options_;
  std::vector<std::filesystem::path> files_;
  std::size_t position_ = 0;
  CloudNotes notes_;
};

}  // namespace evermap
