// SPDX-FileCopyrightText: 2026 the evermap authors
// SPDX-License-Identifier: BSD-3-Clause
#include <algorithm>
#include <cmath>
#include <memory>
#include <numeric>

#include <fmt/format.h>

#include "experiments/contest_story.hpp"
#include "experiments/experiment.hpp"
#include "experiments/scenario_course.hpp"
#include <evermap/geometry/voxel_key.hpp>

namespace evermap {
namespace {

constexpr std::size_t kLateScans = 50;  ///< of the scenario: the pile is measured where they observed it

struct Round {
  bool has_grids;  ///< then scans are left out, since OctoMap needs seconds for each; else all at 10 Hz
  double leaf;     ///< [m]

  /// Also of the files that its figures are drawn to.
  std::string name() const { return fmt::format("c_{}_{}", has_grids ? "quarry" : "loop", leaf); }
  std::string data() const {
    return fmt::format("quarry, {}leaf {} m", has_grids ? "" : "whole loop at 10 Hz, ", leaf);
  }
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

std::vector<std::unique_ptr<Contender>> drivers(const Round& round, const LidarParameters& lidar) {
  if (round.has_grids) return usual_contenders(round.leaf, lidar);
  return contenders_named({"static map", "evermap paper", kEvermap}, round.leaf, lidar);
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
    const ScenarioCourse course(chosen, setup.seed);
    const Points pile = course.observed_lately("pile", kLateScans);
    const ContestRules rules{.leaf = round.leaf,
                             .measurements = measurements,
                             .has_picture = true,
                             .at_end = [&](const Contender&, const Points& map, const Truth& truth) {
                               return pile_distance(map, truth, pile, round.leaf);
                             }};
    return hold_contest(course, drivers(round, course.lidar), rules, progress);
  };
  return {round.name(),
          {{"leaf", round.leaf},
           {"every", chosen.every},
           {"scans", chosen.scans.value()},
           {"seed", setup.seed},
           {"measurements", measurements},
           {"truth_spacing", chosen.truth_spacing}},
          compute};
}

HtmlTable pile_table(const std::vector<Round>& rounds, const std::vector<Json>& results) {
  HtmlTable table{
      "Mean distance [m] of the map to the true surface of the piles, where the last 50 scans (5 s) of the "
      "scenario observed them. The piles under the belts grow by up to 25 cm in that time",
      {{"map", HtmlTable::Best::kNone, 0}},
      {}};
  for (const Round& round : rounds) table.columns.push_back({round.data(), HtmlTable::Best::kLowest, 3});
  for (const std::string& name : contenders_of(results[0])) {
    table.rows.push_back({name});
    for (const Json& result : results) table.rows.back().emplace_back(at_end(result, name, "pile"));
  }
  return table;
}

void set_aims(Story& story, const std::string& data, const Json& result) {
  aim_at_least(story, data, "SA", 0.995, at_end(result, kEvermap, "SA"));
  aim_at_least(story, data, "DA", 0.95, at_end(result, kEvermap, "DA"));
  if (contender_of(result, kOctoMap) != nullptr) {
    aim_at_least(story, data, "OctoMap's AHD over evermap's", 2,
                 at_end(result, kOctoMap, "AHD") / at_end(result, kEvermap, "AHD"));
  }
  aim_at_most(story, data, "map to pile [m]", 0.03, at_end(result, kEvermap, "pile"));
}

}  // namespace

Experiment experiment_c(const Setup& setup) {
  std::vector<Round> rounds;
  for (const double leaf : leaves_of(setup)) rounds.push_back({true, leaf});
  if (!setup.is_quick) {
    for (const double leaf : leaves_of(setup)) rounds.push_back({false, leaf});
  }
  Experiment experiment{"c", {}, {}, {}};
  for (const Round& round : rounds) experiment.units.push_back(unit_of(setup, round));
  experiment.tell = [=](const std::vector<Json>& results, const std::filesystem::path& folder) {
    Story story{"C: a quarry at work"};
    story.blocks.push_back(Paragraph{
        "Heaps grow and shrink, machines have come and gone since the survey, trucks and people go "
        "about, and the robot drives around. A map is good when it follows the piles, drops what is gone, "
        "keeps the ground whole and shows no trail. Grid mappers need seconds for a scan, so that "
        "beside them scans are left out; the whole loop at 10 Hz is driven without them."});
    for (std::size_t i = 0; i < rounds.size(); ++i) {
      tell_contest(story, folder, rounds[i].name(), rounds[i].data(), results[i],
                   {.curves = {{"COV 0.2", "COV within 0.2 m"}, {"AHD", "AHD", true}},
                    .figure = "The paper's figure 9: how much of the true surface the map covers, and how "
                              "far the two are apart",
                    .view = "The middle of the pit from above at the end"});
      set_aims(story, rounds[i].data(), results[i]);
    }
    story.blocks.push_back(pile_table(rounds, results));
    return story;
  };
  return experiment;
}

}  // namespace evermap
