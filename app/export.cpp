// SPDX-FileCopyrightText: 2026 the evermap authors
// SPDX-License-Identifier: BSD-3-Clause
#include <filesystem>
#include <memory>

#include <fmt/core.h>

#include "options.hpp"
#include "report.hpp"
#include "verbs.hpp"
#include <evermap/io/map_export.hpp>
#include <evermap/io/map_file.hpp>

namespace evermap {
namespace {

struct Options {
  std::filesystem::path map;
  std::filesystem::path output;
};

void run(const Options& options) {
  check_export_extension(options.output);
  check_writable(options.output);
  const Octree octree = load_map(options.map);
  export_map(octree, options.output);
  fmt::print("file     {}\nleaves   {}\n", options.output.string(), LeafCounts(octree).occupied);
}

}  // namespace

void add_export(CLI::App& app) {
  CLI::App* verb = app.add_subcommand("export", "Write a map's occupied leaves for other programs");
  const auto options = std::make_shared<Options>();
  verb->add_option("MAP.evm", options->map, "Map to read")->required();
  verb->add_option("OUT", options->output, "File to write: .pcd, .ply, or OctoMap's .ot or .bt")->required();
  verb->callback([options] { run(*options); });
}

}  // namespace evermap
