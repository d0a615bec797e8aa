// SPDX-FileCopyrightText: 2026 the evermap authors
// SPDX-License-Identifier: BSD-3-Clause
#include <numbers>
#include <random>

#include <fmt/format.h>

#include "experiments/experiment.hpp"
#include "experiments/scenario_dataset.hpp"
#include <evermap/simulation/draw.hpp>
#include <evermap/simulation/random_world.hpp>

namespace evermap {
namespace {

/// A world that nobody tuned anything on, and how a map of it is kept.
struct WorldTrial {
  std::uint64_t seed;
  std::string_view kind;
  RandomDrive drive;
  double leaf;            ///< [m]
  double survey_spacing;  ///< [m]
  bool stands;
  double pose_noise;  ///< [m] and degrees for 10 cm
};

WorldTrial world_trial_of(std::uint64_t seed) {
  std::mt19937_64 random(seed);
  WorldTrial trial;
  trial.seed = seed;
  trial.kind = kWorldKinds[seed % kWorldKinds.size()];
  trial.drive.channels = one_of(random, {16, 32, 64, 128});
  trial.drive.columns = one_of(random, {512, 1024});
  trial.drive.scans = one_of(random, {15, 24, 40, 80});
  trial.drive.starts_at_speed = one_of(random, {true, false});
  trial.drive.changed = one_of(random, {0.1, 0.2, 0.3, 0.5});
  trial.leaf = one_of(random, {0.1, 0.2, 0.2, 0.4, 0.4, 0.8});
  trial.survey_spacing = trial.leaf * one_of(random, {0.25, 0.5, 0.9});
  trial.stands = one_of(random, {false, false, false, true});
  trial.pose_noise = one_of(random, {0.0, 0.0, 0.01, 0.03});
  return trial;
}

Unit unit_of(std::uint64_t seed) {
  const WorldTrial trial = world_trial_of(seed);
  const auto compute = [trial](const Progress& progress) {
    Scenario scenario = parse_scenario(fmt::format("world {}", trial.seed),
                                       random_world(trial.kind, trial.seed, trial.drive));
    scenario.motion_distortion = false;
    const ScenarioDataset dataset(
        std::move(scenario),
        {.survey_spacing = trial.survey_spacing, .truth_spacing = 0.17, .stands_at_middle = trial.stands});
    const double rotation = trial.pose_noise * 10 * std::numbers::pi / 180;
    return compare_mappers(dataset, usual_mappers(trial.leaf, dataset.lidar),
                           {.leaf = trial.leaf, .noise = {trial.pose_noise, rotation, trial.seed}}, progress);
  };
  return {fmt::format("world_{}", seed),
          fmt::format("{}, {} beams, leaf {} m", trial.kind, trial.drive.channels, trial.leaf),
          {{"seed", seed},
           {"kind", trial.kind},
           {"leaf", trial.leaf},
           {"channels", trial.drive.channels},
           {"columns", trial.drive.columns},
           {"scans", trial.drive.scans},
           {"changed", trial.drive.changed},
           {"survey_spacing", trial.survey_spacing},
           {"stands", trial.stands},
           {"pose_noise", trial.pose_noise}},
          compute};
}

}  // namespace

Experiment experiment_worlds(const Setup& setup) {
  // Parameters may be chosen on the worlds 1 to 100 alone: --seed 101 is for reporting.
  const std::uint64_t count = setup.is_quick ? kWorldKinds.size() : 200;
  Experiment experiment{"worlds"};
  for (std::uint64_t i = 0; i < count; ++i) experiment.units.push_back(unit_of(setup.seed + i));
  return experiment;
}

}  // namespace evermap
