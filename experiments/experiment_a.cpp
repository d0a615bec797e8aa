// SPDX-FileCopyrightText: 2026 the evermap authors
// SPDX-License-Identifier: BSD-3-Clause
#include <fmt/format.h>

#include "experiments/experiment.hpp"
#include "experiments/outdated_drive.hpp"
#include "experiments/scenario_dataset.hpp"

namespace evermap {
namespace {

ComparisonRules rules_for(const Setup& setup, double leaf) {
  return {.leaf = leaf, .measurements = setup.is_quick ? 3U : 11U, .has_view = true};
}

Unit street(const Setup& setup, double leaf) {
  const ScenarioChoice choice{.scenario = "street",
                              .scans = setup.is_quick ? 16 : 220,
                              .survey_spacing = leaf < 0.3 ? 0.05 : 0.1,
                              .truth_spacing = setup.is_quick ? 0.31 : 0.17,
                              .area = {Eigen::Vector2d(-105, -40), Eigen::Vector2d(105, 40)},
                              .view = {Eigen::Vector2d(-75, -13), Eigen::Vector2d(75, 13)}};
  const auto compute = [=, rules = rules_for(setup, leaf), seed = setup.seed](const Progress& progress) {
    const ScenarioDataset dataset(choice, seed);
    return compare_mappers(dataset, usual_mappers(leaf, dataset.lidar), rules, progress);
  };
  return {fmt::format("a_street_{}", leaf),
          fmt::format("simulated street, leaf {} m", leaf),
          {{"leaf", leaf},
           {"seed", setup.seed},
           {"scans", *choice.scans},
           {"truth_spacing", choice.truth_spacing}},
          compute};
}

Unit real_drive(const Setup& setup, double leaf) {
  const std::size_t scans = setup.is_quick ? 8 : 80;
  const auto compute = [=, rules = rules_for(setup, leaf),
                        folder = setup.data / kDrive](const Progress& progress) {
    const OutdatedDrive dataset(folder, scans);
    return compare_mappers(dataset, usual_mappers(leaf, dataset.lidar), rules, progress);
  };
  return {fmt::format("a_drive_{}", leaf),
          fmt::format("real drive (KITTI), leaf {} m", leaf),
          {{"leaf", leaf}, {"scans", scans}},
          compute};
}

}  // namespace

Experiment experiment_a(const Setup& setup) {
  Experiment experiment{"a"};
  const std::string missing = why_left_out(setup, kDrive);
  if (!missing.empty()) experiment.left_out.push_back(missing);
  for (const double leaf : leaves_of(setup)) {
    experiment.units.push_back(street(setup, leaf));
    if (missing.empty()) experiment.units.push_back(real_drive(setup, leaf));
  }
  return experiment;
}

}  // namespace evermap
