// SPDX-FileCopyrightText: 2026 the evermap authors
// SPDX-License-Identifier: BSD-3-Clause
#include <algorithm>
#include <string>
#include <system_error>

#include <evermap/files/detail/gzip.hpp>
#include <evermap/files/file_error.hpp>
#include <evermap/io/detail/file_order.hpp>
#include <evermap/io/detail/scan_folder.hpp>

namespace evermap {

ScanFolder::ScanFolder(const std::filesystem::path& path, const CloudOptions& options) : options_(options) {
  const std::string& format = options_.format;
  const auto is_cloud = [&](const std::filesystem::path& file) {
    return format.empty() ? cloud_extension(file).has_value() : cloud_extension(file) == format;
  };
  const auto is_no_text = [](const std::filesystem::path& file) { return !is_text_cloud(file); };
  std::error_code error;
  const std::filesystem::file_status status = std::filesystem::status(path, error);
  if (!std::filesystem::exists(status)) {
    throw FileError(path, "cannot be read: " + error.message() + "; check the path");
  }
  const bool is_folder = std::filesystem::is_directory(status);
  files_ = is_folder ? files_in(path, is_cloud) : std::vector{path};
  if (!format.empty()) {
    // Names that tell nothing: the user does.
    if (files_.empty()) files_ = files_in(path, [](const std::filesystem::path&) { return true; });
    if (files_.empty()) throw FileError(path, "holds no file");
    return;
  }
  if (std::any_of(files_.begin(), files_.end(), is_no_text)) std::erase_if(files_, is_text_cloud);
  if (files_.empty() || !cloud_extension(files_.front())) {
    throw FileError(path, "holds no scan; known are " + std::string(kCloudExtensions));
  }
  for (const std::filesystem::path& file : files_) {
    // A scan that was unpacked beside its compressed file would count twice.
    if (cloud_extension(file) == cloud_extension(files_.front()) && is_gzip(file) == is_gzip(files_.front()))
      continue;
    throw FileError(path, "mixes formats, as of " + files_.front().filename().string() + " and " +
                              file.filename().string() +
                              "; leave one format in the folder, or choose one by --format");
  }
}

std::optional<Scan> ScanFolder::next() {
  if (position_ == files_.size()) return std::nullopt;
  notes_ = {};
  return read_cloud(files_[position_++], options_, &notes_);
}

}  // namespace evermap
