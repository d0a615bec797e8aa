// SPDX-FileCopyrightText: 2026 the evermap authors
// SPDX-License-Identifier: BSD-3-Clause
#include "experiments/experiment.hpp"

#include <algorithm>
#include <filesystem>
#include <memory>
#include <string>
#include <unistd.h>
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

/// Says on the standard error what is under way; results go to the standard output.
void say(const std::string& text) { fmt::print(stderr, "{}\n", text); }

std::vector<Json> results_of(const Laboratory& laboratory, const Experiment& experiment) {
  std::vector<Json> results;
  for (std::size_t i = 0; i < experiment.units.size(); ++i) {
    const Unit& unit = experiment.units[i];
    const bool is_kept = laboratory.stored(unit).has_value();
    say(fmt::format("experiment {}, part {} of {}: {}{}", experiment.name, i + 1, experiment.units.size(),
                    unit.name, is_kept ? " (kept from an earlier run)" : ""));
    std::unique_ptr<ProgressBar> bar;
    results.push_back(laboratory.result(unit, [&](std::size_t done, std::size_t total) {
      if (!bar) bar = std::make_unique<ProgressBar>(total);
      bar->show(done);
    }));
  }
  return results;
}

/// The results of an experiment when all are there.
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
  Json all = Json::object();
  std::vector<Story> stories;
  for (const auto& [name, make] : kExperiments) {
    const bool is_asked_for = options.name == name || options.name == "all";
    const Experiment experiment = make(options.setup);
    if (is_asked_for) {
      for (const std::string& reason : experiment.left_out)
        say(fmt::format("experiment {}: {}", name, reason));
    }
    const auto results =
        is_asked_for ? results_of(laboratory, experiment) : stored_results(laboratory, experiment);
    if (results.empty()) continue;
    // What earlier runs have left there belongs on the page, too.
    stories.push_back(experiment.tell(results, laboratory.folder()));
    for (const std::string& reason : experiment.left_out)
      stories.back().blocks.emplace_back(Paragraph{reason});
    laboratory.write(experiment.name + ".csv", csv_of(stories.back()));
    laboratory.write(experiment.name + ".json", dump(to_json(experiment, results)));
    if (!is_asked_for) continue;
    all[name] = to_json(experiment, results);
    if (!options.as_json) fmt::print("{}", text_of(stories.back()));
    std::fflush(stdout);
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
