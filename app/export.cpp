// SPDX-FileCopyrightText: 2026 the evermap authors
// SPDX-License-Identifier: BSD-3-Clause
#include <filesystem>
#include <memory>
#include <vector>

#include <fmt/core.h>

#include "options.hpp"
#include "report.hpp"
#include "verbs.hpp"
#include <evermap/history/map_history.hpp>
#include <evermap/io/map_export.hpp>
#include <evermap/octomap/octomap_export.hpp>

namespace evermap {
namespace {

struct ExportOptions {
  std::filesystem::path map;
  std::filesystem::path output;
  double tiles = 0;  ///< [m] edge of a tile; 0: one file
};

std::vector<MapFormat> export_formats() {
  std::vector<MapFormat> formats;
  formats.insert(formats.end(), cloud_formats().begin(), cloud_formats().end());
  formats.insert(formats.end(), octomap_formats().begin(), octomap_formats().end());
  return formats;
}

void run_export(const ExportOptions& options) {
  if (options.tiles > 0) {
    const Octree octree = load_map_version(options.map);
    const std::size_t tiles = export_tiles(octree, options.output, options.tiles);
    fmt::print("folder   {}\ntiles    {}\nleaves   {}\n", options.output.string(), tiles,
               LeafCounts(octree).occupied);
    return;
  }
  const std::vector<MapFormat> formats = export_formats();
  check_export_extension(options.output, formats);
  check_writable(options.output);
  const Octree octree = load_map_version(options.map);
  export_map(octree, options.output, formats);
  fmt::print("file     {}\nleaves   {}\n", options.output.string(), LeafCounts(octree).occupied);
}

}  // namespace

void add_export(CLI::App& app) {
  CLI::App* verb = app.add_subcommand("export", "Write a map's occupied leaves for other programs");
  const auto options = std::make_shared<ExportOptions>();
  verb->add_option("MAP.evm", options->map, "Map to read")->required();
  verb->add_option("OUT", options->output,
                   "File to write: .pcd, .ply, .las, OctoMap's .ot or .bt, or .pgm for Nav2")
      ->required();
  verb->add_option("--tiles", options->tiles, "Write a folder of .pcd tiles of that size for Autoware")
      ->check(CLI::Range(1.0, 10000.0))
      ->type_name("M")
      ->default_str("one file");
  verb->callback([options] { run_export(*options); });
}

}  // namespace evermap
