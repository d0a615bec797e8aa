// SPDX-FileCopyrightText: 2026 the evermap authors
// SPDX-License-Identifier: BSD-3-Clause
#include <algorithm>
#include <functional>
#include <limits>
#include <memory>
#include <utility>

#include <fmt/format.h>
#include <oneapi/tbb/parallel_for.h>

#include "experiments/contest_story.hpp"
#include "experiments/experiment.hpp"
#include "experiments/labelled_trials.hpp"
#include "experiments/scenario_course.hpp"
#include <evermap/evaluation/evermap_contender.hpp>

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
  add("+ end guard", [](auto& q) { q.hit_margin = UpdateParameters{}.hit_margin; });
  add("+ memory of 1000 points", [](auto& q) { q.max_count = UpdateParameters{}.max_count; });
  add("+ three confirmations", [](auto& q) { q.confirmations = UpdateParameters{}.confirmations; });
  add("+ viewpoint memory", [](auto& q) { q.standstill = UpdateParameters{}.standstill; });
  add("+ reobserved guard", [](auto& q) { q.spare_reobserved = true; });
  add("+ leaves grow firm", [](auto& q) {
    q.max_log_odds = UpdateParameters{}.max_log_odds;
    q.long_term_hit = UpdateParameters{}.long_term_hit;
  });
  add("+ forgetting in doubt = default", [](auto& q) { q.forgetting = UpdateParameters{}.forgetting; });
  instead("default + sigma-point difference", [](auto& q) { q.trim_leaves = true; });
  return rows;
}

/// What the rules are tried on, as a column group of the table.
struct World {
  std::string name;
  std::string title;
  std::vector<std::string> measures;
};
const std::vector<World>& worlds() {
  static const std::vector<World> list{{"drive", "drive", {"static kept", "parked kept", "moving removed"}},
                                       {"redlight", "red light", {"kept"}},
                                       {"yard", "yard", {"SA", "DA"}},
                                       {"still", "yard, still", {"SA"}},
                                       {"street", "A street", {"SA", "DA", "AHD"}},
                                       {"passing", "B passing", {"SA", "ACC l"}},
                                       {"quarry", "C quarry", {"SA", "DA", "AHD"}}};
  return list;
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
  const ScenarioCourse course(choice, seed);
  std::vector<std::unique_ptr<Contender>> contenders;
  for (Rule& rule : rules()) {
    const Parameters parameters{course.lidar, rule.parameters, {}, {}};
    contenders.push_back(std::make_unique<EvermapContender>(rule.name, leaf, parameters));
  }
  const Json contest = hold_contest(course, std::move(contenders), {.leaf = leaf}, progress);
  Json results = Json::object();
  for (const std::string& name : contenders_of(contest)) {
    for (const char* measure : {"SA", "DA", "AHD", "ACC l"})
      results[name][measure] = at_end(contest, name, measure);
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

Unit unit_of(const Setup& setup, const World& world, double leaf) {
  const std::string folder = world.name == "drive" ? kDrive : kRedlight;
  const auto compute = [=, name = world.name](const Progress& progress) {
    if (name == "drive") return try_on_drive(setup.data / folder, leaf, setup.is_quick, progress);
    if (name == "redlight") return try_on_redlight(setup.data / folder, leaf, progress);
    return try_on_scenario(choice_of(name, leaf, setup.is_quick), leaf, setup.seed, progress);
  };
  return {fmt::format("ablation_{}_{}", world.name, leaf),
          {{"world", world.name}, {"leaf", leaf}, {"quick", setup.is_quick}, {"seed", setup.seed}},
          compute};
}

bool is_real(const World& world) { return world.name == "drive" || world.name == "redlight"; }

/// `results` by the name of the world; worlds that were left out are missing.
HtmlTable rule_table(double leaf, const std::vector<std::pair<World, Json>>& results) {
  using Best = HtmlTable::Best;
  HtmlTable table{fmt::format("Leaf {} m", leaf), {{"rule", Best::kNone, 0}}, {}};
  for (const auto& [world, result] : results) {
    for (const std::string& measure : world.measures) {
      table.columns.push_back({fmt::format("{}: {}", world.title, measure),
                               measure == "AHD" ? Best::kLowest : Best::kHighest, measure == "AHD" ? 3 : 4});
    }
  }
  for (const Rule& rule : rules()) {
    table.rows.push_back({rule.name});
    for (const auto& [world, result] : results) {
      for (const std::string& measure : world.measures)
        table.rows.back().emplace_back(number(result[rule.name][measure]));
    }
  }
  return table;
}

}  // namespace

Experiment experiment_ablation(const Setup& setup) {
  const std::vector<double> leaves = leaves_of(setup);
  Experiment experiment{"ablation", {}, {}, {}};
  std::vector<std::pair<double, World>> parts;
  for (const World& world : worlds()) {
    if (setup.is_quick && !is_real(world) && world.name != "yard") continue;
    const std::string missing =
        is_real(world) ? why_left_out(setup, world.name == "drive" ? kDrive : kRedlight) : "";
    if (!missing.empty()) experiment.left_out.push_back(missing);
    if (!missing.empty()) continue;
    for (const double leaf : leaves) {
      experiment.units.push_back(unit_of(setup, world, leaf));
      parts.emplace_back(leaf, world);
    }
  }
  experiment.tell = [=](const std::vector<Json>& results, const std::filesystem::path&) {
    Story story{"Ablation: one rule after the other"};
    story.blocks.emplace_back(
        Paragraph{"Each row adds one rule to the row before, from the paper to the default; rows that end in "
                  "guard, weight or difference "
                  "and are not the default stand alone. Drive: KITTI, a map built of all scans with the "
                  "trails of movers in it, then updated "
                  "over the same scans. Red light: share kept of what the last scans, too, show within 3 cm. "
                  "Yard, still: 100 scans "
                  "from one place."});
    for (const double leaf : leaves) {
      std::vector<std::pair<World, Json>> columns;
      for (std::size_t i = 0; i < parts.size(); ++i) {
        if (parts[i].first == leaf) columns.emplace_back(parts[i].second, results[i]);
      }
      story.blocks.emplace_back(rule_table(leaf, columns));
    }
    return story;
  };
  return experiment;
}

}  // namespace evermap
