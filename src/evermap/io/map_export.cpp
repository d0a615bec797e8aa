// SPDX-FileCopyrightText: 2026 the evermap authors
// SPDX-License-Identifier: BSD-3-Clause
#include <algorithm>
#include <array>
#include <cctype>
#include <cmath>
#include <string>

#include <evermap/files/file_error.hpp>
#include <evermap/io/detail/pcd.hpp>
#include <evermap/io/detail/ply.hpp>
#include <evermap/io/detail/point_table.hpp>
#include <evermap/io/map_export.hpp>

namespace evermap {
namespace {

constexpr double kFloat32Reach = 10'000;  // [m] beyond, float32 steps by more than 1 mm

double probability(float log_odds) { return 1 / (1 + std::exp(-static_cast<double>(log_odds))); }

PointTable table_of(const Octree& octree) {
  constexpr std::array kNames = {"x",      "y",      "z",      "cov_xx",    "cov_xy", "cov_xz",
                                 "cov_yy", "cov_yz", "cov_zz", "occupancy", "count"};
  PointTable table;
  for (const char* name : kNames) table.columns.push_back({name, PointTable::Type::kFloat32});
  table.values.reserve(octree.leaf_count() * kNames.size());
  double reach = 0;
  octree.for_each_leaf([&](VoxelKey key, const Leaf& leaf) {
    if (!leaf.occupied()) return;
    const Eigen::Vector3d mean = octree.gaussian(key, leaf).mean;
    reach = std::max(reach, mean.cwiseAbs().maxCoeff());
    table.values.insert(table.values.end(), mean.begin(), mean.end());
    table.values.insert(table.values.end(), leaf.covariance.begin(), leaf.covariance.end());
    table.values.push_back(probability(leaf.log_odds));
    table.values.push_back(static_cast<double>(leaf.count));
  });
  if (reach > kFloat32Reach) {
    for (std::size_t axis = 0; axis < 3; ++axis) table.columns[axis].type = PointTable::Type::kFloat64;
  }
  return table;
}

constexpr std::array<MapFormat, 2> kCloudFormats = {{
    {".pcd",
     [](const Octree& octree, const std::filesystem::path& path) { write_pcd(path, table_of(octree)); }},
    {".ply",
     [](const Octree& octree, const std::filesystem::path& path) { write_ply(path, table_of(octree)); }},
}};

/// ".pcd, .ply and .ot"
std::string list_of(std::span<const MapFormat> formats) {
  std::string list;
  for (std::size_t i = 0; i < formats.size(); ++i) {
    if (i > 0) list += i + 1 < formats.size() ? ", " : " and ";
    list += formats[i].extension;
  }
  return list;
}

const MapFormat& format_of(const std::filesystem::path& path, std::span<const MapFormat> formats) {
  std::string extension = path.extension().string();
  std::transform(extension.begin(), extension.end(), extension.begin(),
                 [](unsigned char c) { return static_cast<char>(std::tolower(c)); });
  for (const MapFormat& format : formats) {
    if (format.extension == extension) return format;
  }
  throw FileError(path, "no format is known for this extension; known are " + list_of(formats));
}

}  // namespace

std::span<const MapFormat> cloud_formats() { return kCloudFormats; }

void check_export_extension(const std::filesystem::path& path, std::span<const MapFormat> formats) {
  format_of(path, formats);
}

void export_map(const Octree& octree, const std::filesystem::path& path, std::span<const MapFormat> formats) {
  format_of(path, formats).write(octree, path);
}

}  // namespace evermap
