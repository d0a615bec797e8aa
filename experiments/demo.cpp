// SPDX-FileCopyrightText: 2026 the evermap authors
// SPDX-License-Identifier: BSD-3-Clause
#include "experiments/demo.hpp"

#include <optional>

#include <fmt/format.h>

#include "birds_eye.hpp"
#include "experiments/experiment.hpp"
#include "experiments/result_file.hpp"
#include "experiments/scenario_dataset.hpp"
#include "progress_bar.hpp"
#include <evermap/evaluation/evermap_mapper.hpp>
#include <evermap/io/map_file.hpp>

namespace evermap {
namespace {

constexpr double kShownLeaf = 0.2;  ///< [m] of the maps that are written

struct Outcome {
  Json result;
  std::optional<Octree> after;  ///< evermap's map
};

Outcome run_comparison(const Dataset& dataset, double leaf) {
  Outcome outcome;
  const ProgressBar bar(dataset.scans().size());
  const ComparisonRules rules{.leaf = leaf,
                              .measurements = 6,
                              .has_view = true,
                              .at_end = [&](const Mapper& mapper, const Points&, const Truth&) {
                                if (mapper.name() == kEvermap) outcome.after = *mapper.gaussian_map();
                                return Json::object();
                              }};
  outcome.result = compare_mappers(dataset, usual_mappers(leaf, dataset.lidar), rules,
                                   [&](std::size_t done, std::size_t) { bar.show(done); });
  return outcome;
}

}  // namespace

Json run_demo(const std::filesystem::path& folder) {
  const ScenarioDataset dataset({.scenario = "yard", .survey_spacing = 0.05, .truth_spacing = 0.09}, 1);
  Experiment experiment{"demo"};
  std::vector<Json> results;
  for (const double leaf : {kShownLeaf, 0.4}) {
    Outcome outcome = run_comparison(dataset, leaf);
    experiment.units.push_back(
        {fmt::format("yard_{}", leaf), fmt::format("yard, leaf {} m", leaf), {{"leaf", leaf}}, {}});
    results.push_back(std::move(outcome.result));
    if (leaf != kShownLeaf) continue;
    EvermapMapper before("before", leaf, Parameters{});
    before.start(dataset.survey());
    save_map(folder / "before.evm", *before.gaussian_map());
    save_map(folder / "after.evm", *outcome.after);
    write_pictures(folder, *before.gaussian_map(), *outcome.after,
                   compare(*before.gaussian_map(), *outcome.after));
  }
  return to_json(experiment, results);
}

}  // namespace evermap
