// SPDX-FileCopyrightText: 2026 the evermap authors
// SPDX-License-Identifier: BSD-3-Clause
#include <array>
#include <functional>
#include <sstream>
#include <string>

#include <octomap/OcTree.h>

#include <evermap/files/file_error.hpp>
#include <evermap/io/detail/atomic_file.hpp>
#include <evermap/octomap/octomap_export.hpp>

namespace evermap {
namespace {

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

constexpr std::array<MapFormat, 2> kOctomapFormats = {{{".ot", write_ot}, {".bt", write_bt}}};

}  // namespace

std::span<const MapFormat> octomap_formats() { return kOctomapFormats; }

}  // namespace evermap
