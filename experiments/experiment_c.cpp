// SPDX-FileCopyrightText: 2026 the evermap authors
// SPDX-License-Identifier: BSD-3-Clause
#include <numeric>

#include <fmt/format.h>

#include "experiments/experiment.hpp"
#include "experiments/scenario_dataset.hpp"

namespace evermap {
namespace {

constexpr std::size_t kLateScans = 50;  ///< of the scenario: the pile is measured where they observed it

struct Round {
  bool has_grids;  ///< then scans are left out, since OctoMap needs seconds for each; else all at 10 Hz
  double leaf;     ///< [m]
};

ScenarioChoice choice(const Round& round, bool is_quick) {
  // Scans farther apart than every third would see what has changed too seldom to contradict it, so that
  // where leaves are small the grids' run is shorter instead.
  const bool is_short = round.has_grids && round.leaf < 0.3;
  const std::size_t every = !round.has_grids ? 1 : is_short || is_quick ? 3 : 2;
  return {.scenario = "quarry",
          .every = every,
          .scans = is_quick   ? 12
                   : is_short ? 210
                              : 600,
          .survey_spacing = round.leaf < 0.3 ? 0.07 : 0.1,
          .truth_spacing = is_quick ? 0.47 : 0.23,
          .area = {Eigen::Vector2d(-110, -90), Eigen::Vector2d(110, 100)},
          .view = {Eigen::Vector2d(-60, -48), Eigen::Vector2d(60, 44)}};
}

Mappers mappers_for(const Round& round, const LidarParameters& lidar) {
  if (round.has_grids) return usual_mappers(round.leaf, lidar);
  return mappers_named({"static map", "evermap paper", kEvermap}, round.leaf, lidar);
}

/// Mean distance [m] to the true surface of the map's points near a pile's surface that was observed of late.
Json pile_distance(const Points& map, const Truth& truth, const Points& pile, double leaf) {
  const std::vector<double> to_pile = nearest_distances(map, pile);
  Points near;
  for (std::size_t i = 0; i < map.size(); ++i) {
    if (to_pile[i] <= leaf) near.push_back(map[i]);
  }
  const std::vector<double> distances = truth.distances(near);
  const double sum = std::accumulate(distances.begin(), distances.end(), 0.0);
  return {{"pile", sum / static_cast<double>(distances.size())}};
}

Unit unit_of(const Setup& setup, const Round& round) {
  const ScenarioChoice chosen = choice(round, setup.is_quick);
  const std::size_t measurements = setup.is_quick ? 2 : 12;
  const auto compute = [=](const Progress& progress) {
    const ScenarioDataset dataset(chosen, setup.seed);
    const Points pile = dataset.observed_lately("pile", kLateScans);
    const ComparisonRules rules{.leaf = round.leaf,
                                .measurements = measurements,
                                .has_view = true,
                                .at_end = [&](const Mapper&, const Points& map, const Truth& truth) {
                                  return pile_distance(map, truth, pile, round.leaf);
                                }};
    return compare_mappers(dataset, mappers_for(round, dataset.lidar), rules, progress);
  };
  return {fmt::format("c_{}_{}", round.has_grids ? "quarry" : "loop", round.leaf),
          fmt::format("quarry, {}leaf {} m", round.has_grids ? "" : "whole loop at 10 Hz, ", round.leaf),
          {{"leaf", round.leaf},
           {"every", chosen.every},
           {"scans", chosen.scans.value()},
           {"seed", setup.seed},
           {"measurements", measurements},
           {"truth_spacing", chosen.truth_spacing},
           {"late_scans", kLateScans}},
          compute};
}

}  // namespace

Experiment experiment_c(const Setup& setup) {
  Experiment experiment{"c"};
  for (const bool has_grids : {true, false}) {
    if (setup.is_quick && !has_grids) continue;
    for (const double leaf : leaves_of(setup)) experiment.units.push_back(unit_of(setup, {has_grids, leaf}));
  }
  return experiment;
}

}  // namespace evermap
