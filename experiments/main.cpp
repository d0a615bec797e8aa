// SPDX-FileCopyrightText: 2026 the evermap authors
// SPDX-License-Identifier: BSD-3-Clause
#include <algorithm>
#include <filesystem>
#include <memory>
#include <numeric>
#include <string>
#include <utility>
#include <vector>

#include <fmt/core.h>
#include <fmt/ranges.h>

#include "command_line.hpp"
#include "experiments/demo.hpp"
#include "experiments/experiment.hpp"
#include "experiments/machine.hpp"
#include "experiments/result_cache.hpp"
#include "experiments/result_file.hpp"
#include "progress_bar.hpp"
#include <evermap/io/detail/atomic_file.hpp>
#include <evermap/io/map_file.hpp>

namespace evermap {
namespace {

struct Options {
  std::string name;
  std::filesystem::path folder;
  Setup setup;
  bool any_build = false;
  bool as_json = false;
};

constexpr const char* kDemo = "demo";

struct Entry {
  const char* name;
  Experiment (*make)(const Setup&);
  bool is_of_all = true;  ///< else it is run by its name alone
};

constexpr Entry kExperiments[] = {{"a", experiment_a},
                                  {"b", experiment_b},
                                  {"c", experiment_c},
                                  {"localization", experiment_localization},
                                  {"timing", experiment_timing},
                                  {"ablation", experiment_ablation},
                                  {"robustness", experiment_robustness},
                                  {"year", experiment_year},
                                  {"arena", experiment_arena, false},
                                  {"worlds", experiment_worlds, false}};

/// Computes what is not there yet, and says on the standard error what is under way.
void compute(const ResultCache& cache, const std::vector<Unit>& units) {
  constexpr std::size_t kPercent = 100;
  const ProgressBar bar(kPercent, "percent");
  std::vector<Unit> missing;
  for (const Unit& unit : units) {
    if (cache.stored(unit)) {
      bar.say(fmt::format("{} (kept from an earlier run)", unit.name));
    } else {
      missing.push_back(unit);
    }
  }
  std::size_t begun = 0;
  std::vector<std::size_t> percent(missing.size());
  cache.compute(missing, [&](std::size_t i, std::size_t done, std::size_t total) {
    if (done == 0) bar.say(fmt::format("part {} of {}: {}", ++begun, missing.size(), missing[i].name));
    percent[i] = kPercent * done / total;
    bar.show(std::accumulate(percent.begin(), percent.end(), std::size_t{0}) / missing.size());
  });
}

/// What computes an experiment again; DIR and DATA stand for folders of the reader's.
std::string command_of(const Experiment& experiment, const Setup& setup) {
  std::string command =
      fmt::format("build/release/experiments/evermap_experiments {} -o DIR", experiment.name);
  if (experiment.name == kDemo) return command;
  if (!setup.data.empty()) command += " --data DATA";
  if (setup.is_quick) command += " --quick";
  command += fmt::format(" --seed {}", setup.seed);
  if (setup.seeds != Setup{}.seeds) command += fmt::format(" --seeds {}", setup.seeds);
  if (!setup.leaves.empty()) command += fmt::format(" --leaf {}", fmt::join(setup.leaves, ","));
  return command;
}

/// Writes NAME.json, which pictures and the page are drawn from, and NAME.csv.
void write_results(const std::filesystem::path& folder, const Experiment& experiment, const Setup& setup,
                   const Json& units) {
  const Json whole{{"experiment", experiment.name},
                   {"quick", setup.is_quick},
                   {"command", command_of(experiment, setup)},
                   {"machine", machine_facts()},
                   {"left_out", experiment.left_out},
                   {"units", units}};
  write_file(folder / (experiment.name + ".json"), dump(whole));
  write_file(folder / (experiment.name + ".csv"), to_csv(units));
}

Json run_experiments(const Options& options) {
  std::vector<Experiment> experiments;
  std::vector<Unit> units;
  for (const auto& [name, make, is_of_all] : kExperiments) {
    if (options.name != name && !(options.name == "all" && is_of_all)) continue;
    const Experiment& experiment = experiments.emplace_back(make(options.setup));
    for (const std::string& reason : experiment.left_out)
      fmt::print(stderr, "experiment {}: {}\n", name, reason);
    units.insert(units.end(), experiment.units.begin(), experiment.units.end());
  }
  const ResultCache cache(options.folder, options.any_build);
  compute(cache, units);
  Json all = Json::object();
  for (const Experiment& experiment : experiments) {
    std::vector<Json> results;
    for (const Unit& unit : experiment.units) results.push_back(cache.result(unit, {}));
    all[experiment.name] = to_json(experiment, results);
    write_results(options.folder, experiment, options.setup, all[experiment.name]);
  }
  return all;
}

Json run_demo_into(const std::filesystem::path& folder) {
  make_folder(folder);
  const Json units = run_demo(folder);
  write_results(folder, {kDemo}, {}, units);
  return {{kDemo, units}};
}

void run(const Options& options) {
  Json all = options.name == kDemo ? run_demo_into(options.folder) : run_experiments(options);
  for (auto& units : all) units = without_views(std::move(units));
  if (options.as_json) fmt::print("{}", dump(all));
  if (options.as_json) return;
  for (const auto& [name, units] : all.items())
    fmt::print("results  {}\n", (options.folder / (name + ".json")).string());
}

std::vector<std::string> names() {
  std::vector<std::string> names;
  for (const Entry& entry : kExperiments) names.emplace_back(entry.name);
  names.emplace_back("all");
  names.emplace_back(kDemo);
  return names;
}

void add_options(CLI::App& app) {
  const auto options = std::make_shared<Options>();
  app.add_option("NAME", options->name, fmt::format("One of: {}", fmt::join(names(), " ")))
      ->required()
      ->check(CLI::IsMember(names()));
  app.add_option("-o,--output", options->folder,
                 "Folder for results; what it holds already is not computed again")
      ->required()
      ->type_name("DIR");
  app.add_option("--data", options->setup.data, "Folder with kitti_0005_drive and kitti_redlight_standstill")
      ->type_name("DIR")
      ->default_str("no real data");
  app.add_flag("--quick", options->setup.is_quick, "Fewer scans and leaf sizes: minutes instead of hours");
  app.add_option("--seed", options->setup.seed, "Seed of the simulated sensor's noise")
      ->type_name("S")
      ->capture_default_str();
  app.add_option("--seeds", options->setup.seeds, "Seeds that the robustness is measured with")
      ->check(CLI::Range(1, 100))
      ->type_name("N")
      ->capture_default_str();
  app.add_option("--leaf", options->setup.leaves, "Leaf edges instead of each experiment's own")
      ->delimiter(',')
      ->check(CLI::Range(kLeastLeafEdge, kGreatestLeafEdge))
      ->type_name("M,M,..")
      ->default_str("0.2,0.4");
  app.add_flag("--any-build", options->any_build, "Also keep what another build of evermap computed");
  app.add_flag("--json", options->as_json, "Print the results as one JSON object");
  app.callback([options] { run(*options); });
}

}  // namespace
}  // namespace evermap

int main(int argc, char** argv) {
  return evermap::run_command_line(argc, argv, "evermap_experiments",
                                   "Compares evermap with other mappers, on simulated and real data; "
                                   "experiments/report.py draws what this writes.",
                                   evermap::add_options);
}
