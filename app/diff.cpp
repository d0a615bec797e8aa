// SPDX-FileCopyrightText: 2026 the evermap authors
// SPDX-License-Identifier: BSD-3-Clause
#include <filesystem>
#include <memory>
#include <stdexcept>

#include <fmt/core.h>

#include "options.hpp"
#include "report.hpp"
#include "verbs.hpp"
#include <evermap/history/map_history.hpp>
#include <evermap/io/detail/atomic_file.hpp>
#include <evermap/io/detail/pcd.hpp>
#include <evermap/io/detail/point_table.hpp>

namespace evermap {
namespace {

struct DiffOptions {
  std::filesystem::path before;
  std::filesystem::path after;
  std::filesystem::path report;  ///< folder; empty when not asked for
  std::filesystem::path cloud;   ///< empty when not asked for
  bool as_json = false;
};

/// What came (change 1) and what went (-1).
void write_cloud(const std::filesystem::path& path, const MapDifference& difference, const Octree& before,
                 const Octree& after) {
  PointTable table;
  for (const char* name : {"x", "y", "z", "change"})
    table.columns.push_back({name, PointTable::Type::kFloat32});
  const auto add = [&](const std::vector<VoxelKey>& keys, const Octree& octree, double change) {
    for (const VoxelKey key : keys) {
      const Eigen::Vector3d mean = octree.gaussian(key, *octree.find(key)).mean;
      table.values.insert(table.values.end(), mean.begin(), mean.end());
      table.values.push_back(change);
    }
  };
  add(difference.added, after, 1);
  add(difference.moved, after, 1);
  add(difference.removed, before, -1);
  write_pcd(path, table);
}

void run_diff(const DiffOptions& options) {
  const Octree before = load_map_version(options.before);
  const Octree after = load_map_version(options.after);
  if (before.grid() != after.grid())
    throw std::runtime_error("the maps have leaves of another size, or in other places");
  const MapChange change(options.after, before, after);
  if (!options.report.empty()) {
    prepare_report(options.report);
    write_report(options.report, to_json(change), change, before, after);
  }
  if (!options.cloud.empty()) write_cloud(options.cloud, change.difference, before, after);
  fmt::print("{}", options.as_json ? dump(to_json(change)) : to_text(change));
}

}  // namespace

void add_diff(CLI::App& app) {
  CLI::App* verb = app.add_subcommand("diff", "What changed between two maps, or two versions of one");
  const auto options = std::make_shared<DiffOptions>();
  verb->add_option("BEFORE", options->before, "Map, or a version of one: map.evm@3, map.evm@TAG")->required();
  verb->add_option("AFTER", options->after, "Likewise")->required();
  add_report_option(*verb, options->report);
  verb->add_option("--pcd", options->cloud, "Points of what came (change 1) and what went (-1), to write")
      ->type_name("FILE.pcd");
  add_json_option(*verb, options->as_json);
  verb->callback([options] { run_diff(*options); });
}

}  // namespace evermap
