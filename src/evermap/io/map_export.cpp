// SPDX-FileCopyrightText: 2026 the evermap authors
// SPDX-License-Identifier: BSD-3-Clause
#include <algorithm>
#include <array>
#include <cmath>
#include <functional>
#include <sstream>
#include <string>

#include <octomap/OcTree.h>

#include <evermap/files/file_error.hpp>
#include <evermap/io/atomic_file.hpp>
#include <evermap/io/map_export.hpp>
#include <evermap/io/pcd.hpp>
#include <evermap/io/ply.hpp>

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

octomap::OcTree octomap_of(const Octree& octree, const std::filesystem::path& path) {
  octomap::OcTree tree(octree.grid().edge);
  // OctoMap would clamp what we know better; the limits are not part of its files.
  tree.setClampingThresMin(0);
  tree.setClampingThresMax(1);
  octree.for_each_leaf([&](VoxelKey key, const Leaf& leaf) {
    if (!leaf.occupied()) return;
    const Eigen::Vector3d center = octree.grid().center(key);
    octomap::OcTreeKey octomap_key;
    if (!tree.coordToKeyChecked(center.x(), center.y(), center.z(), octomap_key)) {
      throw FileError(path, "the map reaches further from its frame's origin than the " +
                                std::to_string(32768 * octree.grid().edge) +
                                " m of an OctoMap of this resolution; export it as .pcd or .ply");
    }
    tree.setNodeValue(octomap_key, leaf.log_odds, true);
  });
  tree.updateInnerOccupancy();
  return tree;
}

void write_stream(const std::filesystem::path& path, const std::function<bool(std::ostream&)>& write) {
  std::ostringstream stream;
  if (!write(stream) || !stream) throw FileError(path, "OctoMap cannot write this map");
  AtomicFile file(path);
  file.write(stream.view());
  file.commit();
}

void write_ot(const Octree& octree, const std::filesystem::path& path) {
  const octomap::OcTree tree = octomap_of(octree, path);
  write_stream(path, [&](std::ostream& stream) { return tree.write(stream); });
}

void write_bt(const Octree& octree, const std::filesystem::path& path) {
  octomap::OcTree tree = octomap_of(octree, path);
  tree.toMaxLikelihood();
  tree.prune();
  // The header by hand, because OcTree::writeBinary also prints to the standard error.
  write_stream(path, [&](std::ostream& stream) {
    stream << "# Octomap OcTree binary file\nid " << tree.getTreeType() << "\nsize " << tree.size()
           << "\nres " << tree.getResolution() << "\ndata\n";
    tree.writeBinaryData(stream);
    return true;
  });
}

using Writer = void (*)(const Octree&, const std::filesystem::path&);

struct Format {
  std::string_view extension;
  Writer write;
};
constexpr std::array<Format, 4> kFormats = {{
    {".pcd",
     [](const Octree& octree, const std::filesystem::path& path) { write_pcd(path, table_of(octree)); }},
    {".ply",
     [](const Octree& octree, const std::filesystem::path& path) { write_ply(path, table_of(octree)); }},
    {".ot", write_ot},
    {".bt", write_bt},
}};

Writer writer_for(const std::filesystem::path& path) {
  std::string extension = path.extension().string();
  std::transform(extension.begin(), extension.end(), extension.begin(),
                 [](unsigned char c) { return static_cast<char>(std::tolower(c)); });
  for (const Format& format : kFormats) {
    if (format.extension == extension) return format.write;
  }
  throw FileError(path, "no format is known for this extension; known are " + std::string(kExportExtensions));
}

}  // namespace

void check_export_extension(const std::filesystem::path& path) { writer_for(path); }

void export_map(const Octree& octree, const std::filesystem::path& path) { writer_for(path)(octree, path); }

}  // namespace evermap
