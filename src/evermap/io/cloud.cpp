// SPDX-FileCopyrightText: 2026 the evermap authors
// SPDX-License-Identifier: BSD-3-Clause
#include <algorithm>
#include <array>
#include <cstdio>
#include <string>

#include <evermap/files/detail/gzip.hpp>
#include <evermap/files/file_error.hpp>
#include <evermap/io/cloud.hpp>
#include <evermap/io/detail/bin.hpp>
#include <evermap/io/detail/las.hpp>
#include <evermap/io/detail/npy.hpp>
#include <evermap/io/detail/octomap_file.hpp>
#include <evermap/io/detail/pcd.hpp>
#include <evermap/io/detail/ply.hpp>
#include <evermap/io/detail/text_cloud.hpp>

namespace evermap {
namespace {

struct Format {
  std::string_view extension;
  Scan (*read)(const std::filesystem::path& path, const CloudOptions& options, CloudNotes* notes);
};

Scan read_bin_cloud(const std::filesystem::path& path, const CloudOptions& options, CloudNotes* notes) {
  return read_bin(path, options.bin_fields, notes);
}
Scan read_pcd_cloud(const std::filesystem::path& path, const CloudOptions& options, CloudNotes* notes) {
  Scan scan = read_pcd(path, notes);
  if (options.ignore_viewpoint) scan.T_map_sensor.reset();
  return scan;
}
Scan read_ply_cloud(const std::filesystem::path& path, const CloudOptions&, CloudNotes* notes) {
  return read_ply(path, notes);
}
Scan read_las_cloud(const std::filesystem::path& path, const CloudOptions&, CloudNotes* notes) {
  return read_las(path, notes);
}
Scan read_npy_cloud(const std::filesystem::path& path, const CloudOptions&, CloudNotes* notes) {
  return read_npy(path, notes);
}
Scan read_any_text(const std::filesystem::path& path, const CloudOptions&, CloudNotes* notes) {
  return read_text_cloud(path, notes);
}
Scan read_octomap_cloud(const std::filesystem::path& path, const CloudOptions&, CloudNotes* notes) {
  return read_octomap(path, notes);
}
constexpr std::array<Format, 11> kFormats = {{{".bin", read_bin_cloud},
                                              {".pcd", read_pcd_cloud},
                                              {".ply", read_ply_cloud},
                                              {".las", read_las_cloud},
                                              {".laz", read_las_cloud},
                                              {".npy", read_npy_cloud},
                                              {".bt", read_octomap_cloud},
                                              {".ot", read_octomap_cloud},
                                              {".xyz", read_any_text},
                                              {".txt", read_any_text},
                                              {".csv", read_any_text}}};

const Format* format_named(const std::string& extension) {
  const auto* format = std::find_if(kFormats.begin(), kFormats.end(),
                                    [&](const Format& known) { return known.extension == extension; });
  return format == kFormats.end() ? nullptr : format;
}

const Format* format_of(const std::filesystem::path& path) {
  std::string extension = without_gzip(path).extension().string();
  for (char& c : extension) {
    if (c >= 'A' && c <= 'Z') c = static_cast<char>(c - 'A' + 'a');
  }
  return format_named(extension);
}

}  // namespace

std::optional<std::string_view> cloud_extension(const std::filesystem::path& path) {
  const Format* format = format_of(path);
  if (format == nullptr) return std::nullopt;
  return format->extension;
}

std::vector<std::string> cloud_extensions() {
  std::vector<std::string> extensions;
  extensions.reserve(kFormats.size());
  for (const Format& format : kFormats) extensions.emplace_back(format.extension);
  return extensions;
}

bool is_text_cloud(const std::filesystem::path& path) {
  const Format* format = format_of(path);
  return format != nullptr && format->read == read_any_text;
}

Scan read_cloud(const std::filesystem::path& path, const CloudOptions& options, CloudNotes* notes) {
  const Format* format = options.format.empty() ? format_of(path) : format_named(options.format);
  if (format == nullptr) {
    throw FileError(path, "is no known kind of point cloud; known are " + std::string(kCloudExtensions));
  }
  return format->read(path, options, notes);
}

void check_coordinate_step(const std::filesystem::path& path, const CloudNotes& notes, double leaf) {
  constexpr double kGreatestFraction = 0.1;  // of a leaf
  if (notes.coordinate_step <= kGreatestFraction * leaf) return;
  std::array<char, 200> text{};
  std::snprintf(text.data(), text.size(),
                "its float32 coordinates step by %.3g m at %.0f m from the origin, too coarse for leaves of "
                "%.3g m; write them as float64, or less an offset",
                notes.coordinate_step, notes.farthest_coordinate, leaf);
  throw FileError(path, text.data());
}

}  // namespace evermap
