// SPDX-FileCopyrightText: 2026 the evermap authors
// SPDX-License-Identifier: BSD-3-Clause
#include <filesystem>
#include <limits>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include <fmt/core.h>

#include "bag_info.hpp"
#include "options.hpp"
#include "report.hpp"
#include "verbs.hpp"
#include <evermap/history/map_history.hpp>

namespace evermap {
namespace {

struct InfoOptions {
  std::filesystem::path map;
  bool as_json = false;
};

struct Box {
  Eigen::Vector3d least;     ///< [m] map frame
  Eigen::Vector3d greatest;  ///< [m] map frame
};

/// Around the voxels of all leaves. REQUIRES: there is one.
Box extent(const Octree& octree) {
  Eigen::Array3i least = Eigen::Array3i::Constant(std::numeric_limits<int>::max());
  Eigen::Array3i greatest = -least;
  octree.for_each_leaf([&](VoxelKey key, const Leaf&) {
    least = least.min(key.voxel().array());
    greatest = greatest.max(key.voxel().array());
  });
  const Eigen::Vector3d half_voxel = Eigen::Vector3d::Constant(octree.grid().edge / 2);
  return {octree.grid().center(least) - half_voxel, octree.grid().center(greatest) + half_voxel};
}

std::vector<double> to_vector(const Eigen::Vector3d& v) { return {v.begin(), v.end()}; }

/// 0: a version of the history is no file of its own.
std::uintmax_t file_bytes(const std::filesystem::path& map) {
  std::error_code error;
  const std::uintmax_t bytes = std::filesystem::file_size(map, error);
  return error ? 0 : bytes;
}

std::string in_words(const std::optional<MapFrame::GeoPoint>& origin) {
  if (!origin) return {};
  return fmt::format(", its origin at {:.8f} north, {:.8f} east, {:.3f} m", origin->latitude,
                     origin->longitude, origin->altitude);
}

void print_json(const InfoOptions& options, const Octree& octree) {
  const LeafCounts leaves(octree);
  Json json = {{"map", options.map.string()},
               {"leaf_edge_m", octree.grid().edge},
               {"grid_origin_m", to_vector(octree.grid().origin)},
               {"frame", octree.frame().name},
               {"origin", nullptr},
               {"leaves", {{"occupied", leaves.occupied}, {"pending", leaves.pending}}},
               {"extent_m", nullptr},
               {"file_bytes", file_bytes(options.map)},
               {"memory_bytes", octree.memory_bytes()}};
  if (const auto& origin = octree.frame().origin)
    json["origin"] = {
        {"latitude", origin->latitude}, {"longitude", origin->longitude}, {"altitude", origin->altitude}};
  if (!octree.empty()) {
    const Box box = extent(octree);
    json["extent_m"] = {{"least", to_vector(box.least)}, {"greatest", to_vector(box.greatest)}};
  }
  fmt::print("{}", dump(json));
}

void print_text(const InfoOptions& options, const Octree& octree) {
  const LeafCounts leaves(octree);
  const Eigen::Vector3d& origin = octree.grid().origin;
  fmt::print(
      "map      {}\nleaf     {} m\norigin   {:.3f} {:.3f} {:.3f} m\nleaves   {} occupied, {} pending\n",
      options.map.string(), octree.grid().edge, origin.x(), origin.y(), origin.z(), leaves.occupied,
      leaves.pending);
  fmt::print("frame    {}{}\n", octree.frame().name, in_words(octree.frame().origin));
  if (!octree.empty()) {
    const auto [least, greatest] = extent(octree);
    fmt::print("extent   x {:.2f} to {:.2f} m, y {:.2f} to {:.2f} m, z {:.2f} to {:.2f} m\n", least.x(),
               greatest.x(), least.y(), greatest.y(), least.z(), greatest.z());
  }
  fmt::print("size     {:.1f} MB in the file, {:.1f} MB in memory\n",
             1e-6 * static_cast<double>(file_bytes(options.map)),
             1e-6 * static_cast<double>(octree.memory_bytes()));
}

void run_info(const InfoOptions& options) {
  if (is_bag(options.map)) {
    print_bag_info(options.map, options.as_json);
    return;
  }
  const Octree octree = load_map_version(options.map);
  options.as_json ? print_json(options, octree) : print_text(options, octree);
}

}  // namespace

void add_info(CLI::App& app) {
  CLI::App* verb = app.add_subcommand("info", "Check a map, or a bag, and say what is in it");
  const auto options = std::make_shared<InfoOptions>();
  verb->add_option("FILE", options->map, "Map (.evm) or bag (.bag, .db3, .mcap, or their folder) to read")
      ->required();
  add_json_option(*verb, options->as_json);
  verb->callback([options] { run_info(*options); });
}

}  // namespace evermap
