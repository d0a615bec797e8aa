// SPDX-FileCopyrightText: 2026 the evermap authors
// SPDX-License-Identifier: BSD-3-Clause
#include <algorithm>
#include <array>
#include <string>

#include <evermap/files/file_error.hpp>
#include <evermap/io/cloud.hpp>
#include <evermap/io/kitti_bin.hpp>
#include <evermap/io/pcd.hpp>
#include <evermap/io/ply.hpp>

namespace evermap {
namespace {

struct Format {
  std::string_view extension;
  Scan (*read)(const std::filesystem::path& path);
};
constexpr std::array<Format, 3> kFormats = {
    {{".bin", read_kitti_bin}, {".pcd", read_pcd}, {".ply", read_ply}}};

const Format* format_of(const std::filesystem::path& path) {
  std::string extension = path.extension().string();
  for (char& c : extension) {
    if (c >= 'A' && c <= 'Z') c = static_cast<char>(c - 'A' + 'a');
  }
  const auto* format = std::find_if(kFormats.begin(), kFormats.end(),
                                    [&](const Format& known) { return known.extension == extension; });
  return format == kFormats.end() ? nullptr : format;
}

}  // namespace

std::optional<std::string_view> cloud_extension(const std::filesystem::path& path) {
  const Format* format = format_of(path);
  if (format == nullptr) return std::nullopt;
  return format->extension;
}

Scan read_cloud(const std::filesystem::path& path) {
  const Format* format = format_of(path);
  if (format == nullptr) {
    throw FileError(path, "is no known kind of point cloud; known are " + std::string(kCloudExtensions));
  }
  return format->read(path);
}

}  // namespace evermap
