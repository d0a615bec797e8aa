// SPDX-FileCopyrightText: 2026 the evermap authors
// SPDX-License-Identifier: BSD-3-Clause
#include <memory>

#include <fmt/core.h>

#include "options.hpp"
#include "report.hpp"
#include "verbs.hpp"
#include <evermap/io/map_file.hpp>

namespace evermap {
namespace {

struct Options {
  RunOptions run;
  std::filesystem::path map;
  double leaf = 0;  ///< [m]
  ParameterOptions parameters;
  bool as_json = false;
};

void run(const Options& options) {
  check_leaf(options.leaf);
  const UpdateParameters parameters = parameters_of(options.parameters);
  check_writable(options.map);
  PosedScans scans(options.run.scans, options.run.poses);
  Octree octree(VoxelGrid::around(scans.first_pose().translation, options.leaf));
  const Run run = run_over(scans, options.run.threads, [&](const Scan& scan, const Pose& T_map_sensor) {
    return add_scan(octree, scan, T_map_sensor, parameters);
  });
  save_map(options.map, octree);
  if (options.as_json) {
    Json json = {{"map", options.map.string()}, {"leaves", octree.leaf_count()}};
    json.update(to_json(run));
    fmt::print("{}", dump(json));
  } else {
    fmt::print("map      {}\nleaves   {}\n{}", options.map.string(), octree.leaf_count(), to_text(run));
  }
}

}  // namespace

void add_build(CLI::App& app) {
  CLI::App* verb = app.add_subcommand("build", "Make a map from posed scans, all of which are trusted");
  const auto options = std::make_shared<Options>();
  add_run_options(*verb, options->run);
  verb->add_option("-o,--output", options->map, "Map to write")->required()->type_name("MAP.evm");
  add_leaf_option(*verb, options->leaf);
  add_range_options(*verb, options->parameters);
  add_config_option(*verb, options->parameters);
  add_json_option(*verb, options->as_json);
  verb->callback([options] { run(*options); });
}

}  // namespace evermap
