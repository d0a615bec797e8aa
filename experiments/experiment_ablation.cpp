// SPDX-FileCopyrightText: 2026 the evermap authors
// SPDX-License-Identifier: BSD-3-Clause
#include <functional>
#include <memory>

#include <fmt/format.h>

#include "experiments/experiment.hpp"
#include "experiments/labelled_trials.hpp"
#include "experiments/scenario_dataset.hpp"
#include <evermap/evaluation/evermap_mapper.hpp>

namespace evermap {
namespace {

struct Rule {
  std::string name;
  UpdateParameters parameters;
};

/// Each row adds one rule to the row before, from the paper to the default; then what the default leaves out.
std::vector<Rule> rules() {
  std::vector<Rule> rows;
  UpdateParameters p = UpdateParameters::paper();
  const auto add = [&](const std::string& name, const std::function<void(UpdateParameters&)>& change) {
    change(p);
    rows.push_back({name, p});
  };
  const auto instead = [&](const std::string& name, const std::function<void(UpdateParameters&)>& change) {
    UpdateParameters other = p;
    change(other);
    rows.push_back({name, other});
  };
  add("paper, inverse third case", [](auto&) {});
  instead("paper, printed third case", [](auto& q) { q.impact = ImpactRule::kEquation5Printed; });
  add("- sigma-point difference", [](auto& q) { q.trim_leaves = false; });
  add("closest approach", [](auto& q) {
    q.impact = ImpactRule::kClosestApproach;
    q.least_impact = UpdateParameters{}.least_impact;
  });
  add("+ noisy-or", [](auto& q) { q.combination = Combination::kNoisyOr; });
  add("+ surface crossing", [](auto& q) { q.surface_crossing = true; });
  add("+ hit margin", [](auto& q) { q.hit_margin = UpdateParameters{}.hit_margin; });
  add("+ memory of 1000 points", [](auto& q) { q.max_count = UpdateParameters{}.max_count; });
  add("+ three confirmations", [](auto& q) { q.confirmations = UpdateParameters{}.confirmations; });
  add("+ viewpoint memory", [](auto& q) { q.standstill = UpdateParameters{}.standstill; });
  add("+ reobserved guard", [](auto& q) { q.spare_reobserved = true; });
  add("+ long-term memory", [](auto& q) {
    q.max_log_odds = UpdateParameters{}.max_log_odds;
    q.long_term_hit = UpdateParameters{}.long_term_hit;
  });
  add("+ forgetting in doubt = default", [](auto& q) { q.forgetting = UpdateParameters{}.forgetting; });
  instead("default + sigma-point difference", [](auto& q) { q.trim_leaves = true; });
  return rows;
}

/// What the rules are tried on; the first two are real data.
constexpr const char* kWorlds[] = {"drive", "redlight", "yard", "still", "street", "passing", "quarry"};

/// The folder of its data; none when it is simulated.
const char* folder_of(const std::string& world) {
  return world == "drive" ? kDrive : world == "redlight" ? kRedlight : nullptr;
}

ScenarioChoice choice_of(const std::string& world, double leaf, bool is_quick) {
  const double spacing = leaf < 0.3 ? 0.07 : 0.1;
  if (world == "yard")
    return {.scenario = "yard", .scans = is_quick ? 10 : 60, .survey_spacing = 0.05, .truth_spacing = 0.09};
  if (world == "still") {
    return {.scenario = "yard",
            .scans = is_quick ? 20 : 100,
            .survey_spacing = 0.05,
            .truth_spacing = 0.09,
            .stands_at_middle = true};
  }
  if (world == "street")
    return {.scenario = "street", .every = 2, .scans = is_quick ? 20 : 220, .survey_spacing = spacing};
  if (world == "passing")
    return {.scenario = "passing", .every = 4, .scans = is_quick ? 60 : 220, .survey_spacing = spacing};
  return {.scenario = "quarry",
          .every = 3,
          .scans = is_quick ? 15 : 180,
          .survey_spacing = 0.1,
          .truth_spacing = 0.27,
          .area = {Eigen::Vector2d(-80, -70), Eigen::Vector2d(80, 60)}};
}

/// A result for each rule, under its name.
Json try_rules(const std::function<Json(const UpdateParameters&)>& score, const Progress& progress) {
  const std::vector<Rule> all = rules();
  Json results = Json::object();
  for (std::size_t i = 0; i < all.size(); ++i) {
    results[all[i].name] = score(all[i].parameters);
    progress(i + 1, all.size());
  }
  return results;
}

Json try_on_scenario(const ScenarioChoice& choice, double leaf, std::uint64_t seed,
                     const Progress& progress) {
  const ScenarioDataset dataset(choice, seed);
  Mappers mappers;
  for (Rule& rule : rules()) {
    const Parameters parameters{dataset.lidar, rule.parameters, {}, {}};
    mappers.push_back(std::make_unique<EvermapMapper>(rule.name, leaf, parameters));
  }
  const Json comparison = compare_mappers(dataset, std::move(mappers), {.leaf = leaf}, progress);
  Json results = Json::object();
  for (const Json& mapper : comparison["mappers"]) {
    for (const char* metric : {"SA", "DA", "AHD", "ACC l"})
      results[mapper["name"].get<std::string>()][metric] = at_end(mapper, metric);
  }
  return results;
}

Json try_on_drive(const std::filesystem::path& folder, double leaf, bool is_quick, const Progress& progress) {
  const DriveTrial trial(folder, is_quick ? 8 : 80);
  return try_rules(
      [&](const UpdateParameters& parameters) {
        const DriveScore score = trial.run(leaf, parameters);
        return Json{{"static kept", score.all_static.value()},
                    {"static kept in the labelled view", score.seen_static.value()},
                    {"parked kept", score.parked.value()},
                    {"moving removed", score.removed()}};
      },
      progress);
}

Json try_on_redlight(const std::filesystem::path& folder, double leaf, const Progress& progress) {
  const RedlightTrial trial(folder);
  return try_rules(
      [&](const UpdateParameters& parameters) {
        return Json{{"kept", trial.run(leaf, parameters)}};
      },
      progress);
}

Unit unit_of(const Setup& setup, const std::string& world, double leaf) {
  const auto compute = [=](const Progress& progress) {
    if (world == "drive") return try_on_drive(setup.data / kDrive, leaf, setup.is_quick, progress);
    if (world == "redlight") return try_on_redlight(setup.data / kRedlight, leaf, progress);
    return try_on_scenario(choice_of(world, leaf, setup.is_quick), leaf, setup.seed, progress);
  };
  return {fmt::format("ablation_{}_{}", world, leaf),
          fmt::format("{}, leaf {} m", world, leaf),
          {{"world", world}, {"leaf", leaf}, {"quick", setup.is_quick}, {"seed", setup.seed}},
          compute};
}

}  // namespace

Experiment experiment_ablation(const Setup& setup) {
  Experiment experiment{"ablation"};
  for (const std::string world : kWorlds) {
    const char* folder = folder_of(world);
    if (setup.is_quick && folder == nullptr && world != "yard") continue;
    const std::string missing = folder != nullptr ? why_left_out(setup, folder) : "";
    if (!missing.empty()) {
      experiment.left_out.push_back(missing);
      continue;
    }
    for (const double leaf : leaves_of(setup)) experiment.units.push_back(unit_of(setup, world, leaf));
  }
  return experiment;
}

}  // namespace evermap
