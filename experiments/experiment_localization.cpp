// SPDX-FileCopyrightText: 2026 the evermap authors
// SPDX-License-Identifier: BSD-3-Clause
#include <memory>

#include <fmt/format.h>

#include "experiments/experiment.hpp"
#include "experiments/outdated_drive.hpp"
#include "experiments/scenario_dataset.hpp"

namespace evermap {
namespace {

/// Who drives what.
struct LocalizationTrial {
  std::string name;   ///< of the unit
  std::string title;  ///< in tables
  std::uint64_t seed;
  int scans;         ///< of the scenario
  bool has_all;      ///< all mappers, or evermap default and the static map alone
  bool finds_poses;  ///< or is given them, for comparison
  bool is_real;      ///< the real drive of experiment A in its outdated map, or the quarry
};

std::vector<LocalizationTrial> trials_of(const Setup& setup) {
  if (setup.is_quick)
    return {{"localization_all", "quarry, one stretch", setup.seed, 24, false, true, false}};
  std::vector<LocalizationTrial> trials{
      {"localization_all", "quarry, one loop", setup.seed, 600, true, true, false},
      {"localization_given", "quarry, one loop, poses given", setup.seed, 600, false, false, false}};
  for (int i = 1; i < setup.seeds; ++i) {
    const auto seed = setup.seed + static_cast<std::uint64_t>(i);
    trials.push_back({fmt::format("localization_seed_{}", seed),
                      fmt::format("quarry, one loop, seed {}", seed), seed, 600, false, true, false});
  }
  trials.push_back({"localization_loops", "quarry, five loops", setup.seed, 3000, false, true, false});
  if (why_left_out(setup, kDrive).empty()) {
    trials.push_back({"localization_drive", "real drive, outdated map", setup.seed, 80, false, true, true});
  }
  return trials;
}

std::unique_ptr<Dataset> dataset_of(const Setup& setup, const LocalizationTrial& trial) {
  if (trial.is_real) {
    return std::make_unique<OutdatedDrive>(setup.data / kDrive, static_cast<std::size_t>(trial.scans));
  }
  const ScenarioChoice choice{.scenario = "quarry",
                              .every = 2,
                              .scans = trial.scans,
                              .truth_spacing = setup.is_quick ? 0.47 : 0.31,
                              .area = {Eigen::Vector2d(-80, -70), Eigen::Vector2d(80, 70)}};
  return std::make_unique<ScenarioDataset>(choice, trial.seed);
}

Unit unit_of(const Setup& setup, double leaf, const LocalizationTrial& trial) {
  const auto compute = [=](const Progress& progress) {
    const std::unique_ptr<Dataset> dataset = dataset_of(setup, trial);
    Mappers mappers = trial.has_all ? usual_mappers(leaf, dataset->lidar)
                                    : mappers_named({"static map", kEvermap}, leaf, dataset->lidar);
    const ComparisonRules rules{.leaf = leaf, .measurements = 6, .finds_poses = trial.finds_poses};
    return compare_mappers(*dataset, std::move(mappers), rules, progress);
  };
  return {trial.name,
          trial.title,
          {{"leaf", leaf},
           {"seed", trial.seed},
           {"scans", trial.scans},
           {"all", trial.has_all},
           {"finds_poses", trial.finds_poses}},
          compute};
}

}  // namespace

Experiment experiment_localization(const Setup& setup) {
  const double leaf = setup.leaves.empty() ? 0.4 : setup.leaves.front();
  Experiment experiment{"localization"};
  const std::string missing = why_left_out(setup, kDrive);
  if (!setup.is_quick && !missing.empty()) experiment.left_out.push_back(missing);
  for (const LocalizationTrial& trial : trials_of(setup))
    experiment.units.push_back(unit_of(setup, leaf, trial));
  return experiment;
}

}  // namespace evermap
