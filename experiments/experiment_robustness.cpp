// SPDX-FileCopyrightText: 2026 the evermap authors
// SPDX-License-Identifier: BSD-3-Clause
#include <numbers>

#include <fmt/format.h>

#include "experiments/experiment.hpp"
#include "experiments/scenario_dataset.hpp"

namespace evermap {
namespace {

struct Variant {
  std::uint64_t seed;
  double translation;  ///< [m] of the poses' noise
  double degrees;      ///< of the same
  bool is_registered;  ///< the poses only start the search for those that fit the map

  std::string title() const {
    if (translation == 0) return fmt::format("seed {}", seed);
    return fmt::format("poses off by {:.0f} cm and {} degrees{}", 100 * translation, degrees,
                       is_registered ? ", registered" : "");
  }
};

std::vector<Variant> variants_of(const Setup& setup) {
  const std::size_t seeds = setup.is_quick ? 0 : static_cast<std::size_t>(setup.seeds);
  std::vector<Variant> variants(seeds);
  for (std::size_t i = 0; i < seeds; ++i) variants[i] = {setup.seed + i, 0, 0, false};
  if (!setup.is_quick) variants.push_back({setup.seed, 0.01, 0.1, false});
  variants.push_back({setup.seed, 0.03, 0.3, false});
  if (!setup.is_quick) variants.push_back({setup.seed, 0.01, 0.1, true});
  if (!setup.is_quick) variants.push_back({setup.seed, 0.03, 0.3, true});
  return variants;
}

Unit unit_of(const Setup& setup, double leaf, const Variant& variant, std::size_t index) {
  const ScenarioChoice choice{.scenario = "quarry",
                              .every = 3,
                              .scans = setup.is_quick ? 12 : 150,
                              .truth_spacing = setup.is_quick ? 0.47 : 0.23,
                              .area = {Eigen::Vector2d(-80, -70), Eigen::Vector2d(80, 60)}};
  const auto compute = [=](const Progress& progress) {
    const ScenarioDataset dataset(choice, variant.seed);
    const PoseNoise noise{variant.translation, variant.degrees * std::numbers::pi / 180, variant.seed};
    return compare_mappers(dataset, mappers_named({kOctoMap, kEvermap}, leaf, dataset.lidar),
                           {.leaf = leaf, .noise = noise, .finds_poses = variant.is_registered}, progress);
  };
  return {fmt::format("robustness_{}", index + 1),
          variant.title(),
          {{"leaf", leaf},
           {"seed", variant.seed},
           {"translation", variant.translation},
           {"degrees", variant.degrees},
           {"registered", variant.is_registered},
           {"scans", *choice.scans}},
          compute};
}

}  // namespace

Experiment experiment_robustness(const Setup& setup) {
  const double leaf = setup.leaves.empty() ? 0.4 : setup.leaves.front();
  Experiment experiment{"robustness"};
  for (const Variant& variant : variants_of(setup))
    experiment.units.push_back(unit_of(setup, leaf, variant, experiment.units.size()));
  return experiment;
}

}  // namespace evermap
