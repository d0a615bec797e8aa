// SPDX-FileCopyrightText: 2026 the evermap authors
// SPDX-License-Identifier: BSD-3-Clause
#include <filesystem>
#include <memory>
#include <string>
#include <system_error>

#include <fmt/core.h>

#include "birds_eye.hpp"
#include "options.hpp"
#include "progress_bar.hpp"
#include "report.hpp"
#include "verbs.hpp"
#include "yard_trial.hpp"
#include <evermap/evaluation/octomap_baseline.hpp>
#include <evermap/io/io_error.hpp>
#include <evermap/io/map_file.hpp>
#include <evermap/update/map_updater.hpp>
#include <evermap/update/viewpoint.hpp>

namespace evermap {
namespace {

struct Options {
  std::filesystem::path folder = "demo";
  bool as_json = false;
};

Octree updated(const YardTrial& trial, const UpdateParameters& parameters) {
  Octree octree = trial.initial_map();
  Viewpoint viewpoint(parameters.standstill);
  ProgressBar bar(trial.size());
  for (std::size_t i = 0; i < trial.size(); ++i) {
    update(octree, trial.scan(i), trial.pose(i), parameters, viewpoint.novelty(trial.pose(i)));
    bar.show(i + 1);
  }
  return octree;
}

YardScore octomap_score(const YardTrial& trial) {
  OctoMapBaseline octomap(trial.initial_map().grid().edge);
  octomap.insert_surface(trial.initial_surface());
  ProgressBar bar(trial.size());
  for (std::size_t i = 0; i < trial.size(); ++i) {
    Points ends;
    for (const Eigen::Vector3d& p_sensor : trial.scan(i).p_sensor) ends.push_back(trial.pose(i) * p_sensor);
    octomap.insert_scan(trial.pose(i).translation, ends, LidarModel{}.max_range);
    bar.show(i + 1);
  }
  return trial.score([&](const Eigen::Vector3d& p_map) { return octomap.occupied(p_map); },
                     octomap.occupied_centers());
}

/// The comparison as it grows: a row of the printed table and an entry of the JSON array.
class Table {
 public:
  explicit Table(bool as_json) : as_json_(as_json) {
    if (as_json_) return;
    fmt::print("{:<6} {:<18} {:>6} {:>6} {:>8} {:>8} {:>8} {:>8} {:>7}\n", "leaf", "map", "SA", "DA",
               "COV 0.1", "COV 0.2", "ACC 0.1", "ACC 0.2", "AHD [m]");
  }

  void add(double edge, const std::string& name, const YardScore& score) {
    const SurfaceComparison& s = score.surface;
    rows_.push_back({{"leaf", edge},
                     {"map", name},
                     {"SA", score.static_accuracy},
                     {"DA", score.dynamic_accuracy},
                     {"COV_0.1", s.coverage(0.1)},
                     {"COV_0.2", s.coverage(0.2)},
                     {"COV_0.5", s.coverage(0.5)},
                     {"ACC_0.1", s.accuracy(0.1)},
                     {"ACC_0.2", s.accuracy(0.2)},
                     {"ACC_0.5", s.accuracy(0.5)},
                     {"mean_truth_to_map", s.mean_truth_to_map()},
                     {"mean_map_to_truth", s.mean_map_to_truth()},
                     {"AHD", s.average_hausdorff_distance()}});
    if (as_json_) return;
    fmt::print("{:<6} {:<18} {:>6.4f} {:>6.4f} {:>8.3f} {:>8.3f} {:>8.3f} {:>8.3f} {:>7.3f}\n", edge, name,
               score.static_accuracy, score.dynamic_accuracy, s.coverage(0.1), s.coverage(0.2),
               s.accuracy(0.1), s.accuracy(0.2), s.average_hausdorff_distance());
  }

  void finish() const {
    if (as_json_) fmt::print("{}", dump(rows_));
  }

 private:
  bool as_json_;
  Json rows_ = Json::array();
};

void run(const Options& options) {
  std::error_code error;
  std::filesystem::create_directories(options.folder, error);
  if (error) throw IoError(options.folder, "the folder cannot be made: " + error.message());
  check_writable(options.folder / "after.evm");
  const Yard yard = make_yard();
  Table table(options.as_json);
  for (const double edge : {0.2, 0.4}) {
    const YardTrial trial(edge, yard.T_map_sensor, yard);
    table.add(edge, "not maintained", trial.score(trial.initial_map()));
    table.add(edge, "OctoMap " + OctoMapBaseline::version(), octomap_score(trial));
    table.add(edge, "evermap paper", trial.score(updated(trial, UpdateParameters::paper())));
    const Octree after = updated(trial, UpdateParameters{});
    table.add(edge, "evermap default", trial.score(after));
    if (edge != 0.2) continue;
    save_map(options.folder / "before.evm", trial.initial_map());
    save_map(options.folder / "after.evm", after);
    write_pictures(options.folder, trial.initial_map(), after, compare(trial.initial_map(), after));
  }
  table.finish();
  if (options.as_json) return;
  fmt::print(
      "\nSA: unchanged surface kept. DA: removed surface erased. COV, ACC: share of the true surface near "
      "the\n"
      "map, of the map near the true surface [m]. Maps and pictures (0.2 m) are in {}/\n",
      options.folder.string());
}

}  // namespace

void add_demo(CLI::App& app) {
  CLI::App* verb = app.add_subcommand("demo", "Simulate a yard that changed, and maintain its map");
  const auto options = std::make_shared<Options>();
  verb->add_option("-o,--output", options->folder, "Folder for maps and pictures")
      ->type_name("DIR")
      ->capture_default_str();
  add_json_option(*verb, options->as_json);
  verb->callback([options] { run(*options); });
}

}  // namespace evermap
