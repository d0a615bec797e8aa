// SPDX-FileCopyrightText: 2026 the evermap authors
// SPDX-License-Identifier: BSD-3-Clause
#include "experiments/experiment.hpp"

#include <algorithm>
#include <filesystem>
#include <memory>
#include <numeric>
#include <string>
#include <vector>

#include <fmt/core.h>
#include <fmt/ranges.h>

#include "experiments/laboratory.hpp"
#include "experiments/page.hpp"
#include "options.hpp"
#include "progress_bar.hpp"
#include "report.hpp"
#include "verbs.hpp"
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

using Maker = Experiment (*)(const Setup&);
struct Known {
  const char* name;
  Maker make;
};
constexpr Known kExperiments[] = {{"a", experiment_a},
                                  {"b", experiment_b},
                                  {"c", experiment_c},
                                  {"localization", experiment_localization},
                                  {"timing", experiment_timing},
                                  {"ablation", experiment_ablation},
                                  {"robustness", experiment_robustness}};

/// Computes what is not there yet, and says on the standard error what is under way.
void compute(const Laboratory& laboratory, const std::vector<Unit>& units) {
  constexpr std::size_t kPercent = 100;
  const ProgressBar bar(kPercent, "percent");
  std::vector<Unit> missing;
  for (const Unit& unit : units) {
    if (laboratory.stored(unit)) {
      bar.say(fmt::format("{} (kept from an earlier run)", unit.name));
    } else {
      missing.push_back(unit);
    }
  }
  std::size_t begun = 0;
  std::vector<std::size_t> percent(missing.size());
  laboratory.compute(missing, [&](std::size_t i, std::size_t done, std::size_t total) {
    if (done == 0) bar.say(fmt::format("part {} of {}: {}", ++begun, missing.size(), missing[i].name));
    percent[i] = kPercent * done / total;
    bar.show(std::accumulate(percent.begin(), percent.end(), std::size_t{0}) / missing.size());
  });
}

/// The results of an experiment when all are there, else none.
std::vector<Json> stored_results(const Laboratory& laboratory, const Experiment& experiment) {
  std::vector<Json> results;
  for (const Unit& unit : experiment.units) {
    auto result = laboratory.stored(unit);
    if (!result) return {};
    results.push_back(std::move(*result));
  }
  return results;
}

void run(const Options& options) {
  for (const double leaf : options.setup.leaves) check_leaf(leaf);
  const Laboratory laboratory(options.folder, options.any_build);
  const auto is_asked_for = [&](const Experiment& experiment) {
    return options.name == experiment.name || options.name == "all";
  };
  std::vector<Experiment> experiments;
  std::vector<Unit> units;
  for (const auto& [name, make] : kExperiments) {
    const Experiment& experiment = experiments.emplace_back(make(options.setup));
    if (!is_asked_for(experiment)) continue;
    for (const std::string& reason : experiment.left_out)
      fmt::print(stderr, "experiment {}: {}\n", name, reason);
    units.insert(units.end(), experiment.units.begin(), experiment.units.end());
  }
  compute(laboratory, units);

  Json all = Json::object();
  std::vector<Story> stories;
  for (const Experiment& experiment : experiments) {
    // What earlier runs have left there belongs on the page, too.
    const auto results = stored_results(laboratory, experiment);
    if (results.empty()) continue;
    stories.push_back(experiment.tell(results, laboratory.folder()));
    for (const std::string& reason : experiment.left_out)
      stories.back().blocks.emplace_back(Paragraph{reason});
    laboratory.write(experiment.name + ".csv", csv_of(stories.back()));
    laboratory.write(experiment.name + ".json", dump(to_json(experiment, results)));
    if (!is_asked_for(experiment)) continue;
    all[experiment.name] = to_json(experiment, results);
    if (!options.as_json) fmt::print("{}", text_of(stories.back()));
  }
  write_page(laboratory, options.setup, stories);
  if (options.as_json) fmt::print("{}", dump(all));
  if (!options.as_json) fmt::print("\npage     {}\n", (options.folder / "index.html").string());
}

std::vector<std::string> names() {
  std::vector<std::string> names;
  for (const auto& [name, make] : kExperiments) names.emplace_back(name);
  names.emplace_back("all");
  return names;
}

}  // namespace

void add_experiment(CLI::App& app) {
  CLI::App* verb =
      app.add_subcommand("experiment", "Repeat the paper's measurements, on simulated and real data");
  const auto options = std::make_shared<Options>();
  verb->add_option("NAME", options->name, fmt::format("One of: {}", fmt::join(names(), " ")))
      ->required()
      ->check(CLI::IsMember(names()));
  verb->add_option("-o,--output", options->folder,
                   "Folder for results; what it holds already is not computed again")
      ->required()
      ->type_name("DIR");
  verb->add_option("--data", options->setup.data,
                   "Folder with kitti_0005_drive and kitti_redlight_standstill")
      ->type_name("DIR")
      ->default_str("no real data");
  verb->add_flag("--quick", options->setup.is_quick,
                 "Fewer scans and leaf sizes: two minutes instead of half an hour");
  verb->add_option("--seed", options->setup.seed, "Seed of the simulated sensor's noise")
      ->type_name("S")
      ->capture_default_str();
  verb->add_option("--seeds", options->setup.seeds, "Seeds that the robustness is measured with")
      ->check(CLI::Range(1, 100))
      ->type_name("N")
      ->capture_default_str();
  verb->add_option("--leaf", options->setup.leaves, "Leaf edges instead of each experiment's own")
      ->delimiter(',')
      ->type_name("M,M,..")
      ->default_str("0.2,0.4");
  verb->add_flag("--any-build", options->any_build,
                 "Also keep what another build of evermap computed, to draw the page anew");
  add_json_option(*verb, options->as_json);
  verb->callback([options] { run(*options); });
}

}  // namespace evermap
