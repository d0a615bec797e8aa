// SPDX-FileCopyrightText: 2026 the evermap authors
// SPDX-License-Identifier: BSD-3-Clause
#include <fmt/format.h>

#include "experiments/experiment.hpp"
#include "experiments/redlight_dataset.hpp"
#include "experiments/scenario_dataset.hpp"

namespace evermap {
namespace {

Unit passing(const Setup& setup, double leaf) {
  const ScenarioChoice choice{.scenario = "passing",
                              .every = setup.is_quick ? 40U : 1U,
                              .survey_spacing = leaf < 0.3 ? 0.05 : 0.1,
                              .truth_spacing = setup.is_quick ? 0.31 : 0.17,
                              .area = {Eigen::Vector2d(-45, -25), Eigen::Vector2d(45, 25)}};
  const std::size_t measurements = setup.is_quick ? 11 : 53;
  const auto compute = [=, seed = setup.seed](const Progress& progress) {
    const ScenarioDataset dataset(choice, seed);
    return compare_mappers(dataset, usual_mappers(leaf, dataset.lidar),
                           {.leaf = leaf, .measurements = measurements, .has_view = true}, progress);
  };
  return {fmt::format("b_passing_{}", leaf),
          fmt::format("simulated standstill, leaf {} m", leaf),
          {{"leaf", leaf},
           {"seed", setup.seed},
           {"every", choice.every},
           {"measurements", measurements},
           {"truth_spacing", choice.truth_spacing}},
          compute};
}

Unit redlight(const Setup& setup, double leaf) {
  const auto compute = [=, folder = setup.data / kRedlight](const Progress& progress) {
    const RedlightDataset dataset(folder);
    return compare_mappers(dataset, usual_mappers(leaf, dataset.lidar),
                           {.leaf = leaf, .measurements = 22, .has_view = true}, progress);
  };
  return {fmt::format("b_redlight_{}", leaf),
          fmt::format("real red light (KITTI), leaf {} m", leaf),
          {{"leaf", leaf}},
          compute};
}

}  // namespace

Experiment experiment_b(const Setup& setup) {
  const std::vector<double> leaves =
      setup.leaves.empty() ? std::vector{setup.is_quick ? 0.4 : 0.2} : setup.leaves;
  Experiment experiment{"b"};
  const std::string missing = why_left_out(setup, kRedlight);
  if (!missing.empty()) experiment.left_out.push_back(missing);
  for (const double leaf : leaves) {
    experiment.units.push_back(passing(setup, leaf));
    if (missing.empty()) experiment.units.push_back(redlight(setup, leaf));
  }
  return experiment;
}

}  // namespace evermap
