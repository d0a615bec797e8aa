// SPDX-FileCopyrightText: 2026 the evermap authors
// SPDX-License-Identifier: BSD-3-Clause
#include <algorithm>
#include <string>
#include <system_error>

#include <evermap/files/file_error.hpp>
#include <evermap/io/cloud.hpp>
#include <evermap/io/scan_source.hpp>

namespace evermap {
namespace {

/// The clouds of a folder in the order of their names. Hidden files are none: archivers and file servers
/// leave them beside the real ones under the same extension.
std::vector<std::filesystem::path> clouds_in(const std::filesystem::path& folder) {
  std::vector<std::filesystem::path> files;
  std::error_code error;
  for (std::filesystem::directory_iterator entry(folder, error), end; !error && entry != end;
       entry.increment(error)) {
    const std::filesystem::path& file = entry->path();
    std::error_code ignored;
    if (cloud_extension(file) && !file.filename().string().starts_with('.') &&
        entry->is_regular_file(ignored)) {
      files.push_back(file);
    }
  }
  if (error) throw FileError(folder, "cannot be listed: " + error.message());
  std::sort(files.begin(), files.end());
  return files;
}

}  // namespace

ScanSource::ScanSource(const std::filesystem::path& path) {
  std::error_code error;
  const std::filesystem::file_status status = std::filesystem::status(path, error);
  if (!std::filesystem::exists(status)) {
    throw FileError(path, "cannot be read: " + error.message() + "; check the path");
  }
  files_ = std::filesystem::is_directory(status) ? clouds_in(path) : std::vector{path};
  if (files_.empty() || !cloud_extension(files_.front())) {
    throw FileError(path, "holds no scan; known are " + std::string(kCloudExtensions));
  }
  for (const std::filesystem::path& file : files_) {
    if (cloud_extension(file) == cloud_extension(files_.front())) continue;
    throw FileError(path, "mixes formats, as of " + files_.front().filename().string() + " and " +
                              file.filename().string() + "; leave one format in the folder");
  }
}

std::optional<Scan> ScanSource::next() {
  if (position_ == files_.size()) return std::nullopt;
  return read_cloud(files_[position_++]);
}

}  // namespace evermap
