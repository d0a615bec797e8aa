// SPDX-FileCopyrightText: 2026 the evermap authors
// SPDX-License-Identifier: BSD-3-Clause
#include <algorithm>
#include <array>
#include <cctype>
#include <cmath>
#include <cstdio>
#include <map>
#include <string>
#include <utility>
#include <vector>

#include <evermap/files/file_error.hpp>
#include <evermap/io/detail/atomic_file.hpp>
#include <evermap/io/detail/las.hpp>
#include <evermap/io/detail/occupancy_grid.hpp>
#include <evermap/io/detail/pcd.hpp>
#include <evermap/io/detail/ply.hpp>
#include <evermap/io/detail/point_table.hpp>
#include <evermap/io/map_export.hpp>

namespace evermap {
namespace {

constexpr double kFloat32Reach = 10'000;  // [m] beyond, float32 steps by more than 1 mm

double probability(float log_odds) { return 1 / (1 + std::exp(-static_cast<double>(log_odds))); }

/// Rows of leaves, as they come.
class LeafTable {
 public:
  LeafTable() {
    constexpr std::array kNames = {"x",      "y",      "z",      "cov_xx",    "cov_xy", "cov_xz",
                                   "cov_yy", "cov_yz", "cov_zz", "occupancy", "count"};
    for (const char* name : kNames) table_.columns.push_back({name, PointTable::Type::kFloat32});
  }
  void add(const Eigen::Vector3d& mean, const Leaf& leaf) {
    reach_ = std::max(reach_, mean.cwiseAbs().maxCoeff());
    table_.values.insert(table_.values.end(), mean.begin(), mean.end());
    table_.values.insert(table_.values.end(), leaf.covariance.begin(), leaf.covariance.end());
    table_.values.push_back(probability(leaf.log_odds));
    table_.values.push_back(static_cast<double>(leaf.count));
  }
  PointTable finish() {
    if (reach_ > kFloat32Reach) {
      for (std::size_t axis = 0; axis < 3; ++axis) table_.columns[axis].type = PointTable::Type::kFloat64;
    }
    return std::move(table_);
  }

 private:
  PointTable table_;
  double reach_ = 0;  ///< [m]
};

template <class Visit>
void for_each_occupied(const Octree& octree, Visit&& visit) {
  octree.for_each_leaf([&](VoxelKey key, const Leaf& leaf) {
    if (leaf.occupied()) visit(octree.gaussian(key, leaf).mean, leaf);
  });
}

PointTable table_of(const Octree& octree) {
  LeafTable table;
  for_each_occupied(octree, [&](const Eigen::Vector3d& mean, const Leaf& leaf) { table.add(mean, leaf); });
  return table.finish();
}

void export_las(const Octree& octree, const std::filesystem::path& path) {
  std::vector<Eigen::Vector3d> points;
  for_each_occupied(octree, [&](const Eigen::Vector3d& mean, const Leaf&) { points.push_back(mean); });
  write_las(path, points);
}

constexpr std::array<MapFormat, 4> kCloudFormats = {{
    {".pcd",
     [](const Octree& octree, const std::filesystem::path& path) { write_pcd(path, table_of(octree)); }},
    {".ply",
     [](const Octree& octree, const std::filesystem::path& path) { write_ply(path, table_of(octree)); }},
    {".las", export_las},
    {".pgm", write_occupancy_grid},
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

std::size_t export_tiles(const Octree& octree, const std::filesystem::path& folder, double edge) {
  using Tile = std::pair<std::int64_t, std::int64_t>;
  std::map<Tile, LeafTable> tiles;
  for_each_occupied(octree, [&](const Eigen::Vector3d& mean, const Leaf& leaf) {
    const auto along = [&](double x) { return static_cast<std::int64_t>(std::floor(x / edge)); };
    tiles[{along(mean.x()), along(mean.y())}].add(mean, leaf);
  });
  make_folder(folder);
  const std::string resolution = std::to_string(edge);
  std::string metadata = "x_resolution: " + resolution + "\ny_resolution: " + resolution + "\n";
  for (auto& [tile, leaves] : tiles) {
    const std::string name = std::to_string(tile.first) + "_" + std::to_string(tile.second) + ".pcd";
    write_pcd(folder / name, leaves.finish());
    metadata += name + ": [" + std::to_string(static_cast<double>(tile.first) * edge) + ", " +
                std::to_string(static_cast<double>(tile.second) * edge) + "]\n";
  }
  if (const auto& origin = octree.frame().origin) {
    AtomicFile projector(folder / "map_projector_info.yaml");
    std::array<char, 200> text{};
    std::snprintf(text.data(), text.size(),
                  "projector_type: LocalCartesian\nvertical_datum: WGS84\nmap_origin:\n  latitude: %.10f\n"
                  "  longitude: %.10f\n  altitude: %.4f\n",
                  origin->latitude, origin->longitude, origin->altitude);
    projector.write(text.data());
    projector.commit();
  }
  AtomicFile file(folder / "pointcloud_map_metadata.yaml");
  file.write(metadata);
  file.commit();
  return tiles.size();
}

}  // namespace evermap
