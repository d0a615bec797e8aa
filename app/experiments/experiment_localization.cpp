// SPDX-FileCopyrightText: 2026 the evermap authors
// SPDX-License-Identifier: BSD-3-Clause
#include <memory>

#include <fmt/format.h>

#include "experiments/contest_story.hpp"
#include "experiments/experiment.hpp"
#include "experiments/outdated_drive.hpp"
#include "experiments/scenario_course.hpp"

namespace evermap {
namespace {

/// Who drives what.
struct Trial {
  std::string name;   ///< of the unit
  std::string title;  ///< in tables
  std::uint64_t seed;
  int scans;         ///< of the scenario
  bool has_all;      ///< all contenders, or evermap default and the static map alone
  bool finds_poses;  ///< or is given them, for comparison
  bool is_real;      ///< the real drive of experiment A in its outdated map, or the quarry
};

std::vector<Trial> trials_of(const Setup& setup) {
  if (setup.is_quick)
    return {{"localization_all", "quarry, one stretch", setup.seed, 24, false, true, false}};
  std::vector<Trial> trials{
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

std::unique_ptr<Course> course_of(const Setup& setup, const Trial& trial) {
  if (trial.is_real) {
    return std::make_unique<OutdatedDrive>(setup.data / kDrive, static_cast<std::size_t>(trial.scans));
  }
  const ScenarioChoice choice{.scenario = "quarry",
                              .every = 2,
                              .scans = trial.scans,
                              .truth_spacing = setup.is_quick ? 0.47 : 0.31,
                              .area = {Eigen::Vector2d(-80, -70), Eigen::Vector2d(80, 70)}};
  return std::make_unique<ScenarioCourse>(choice, trial.seed);
}

Unit unit_of(const Setup& setup, double leaf, const Trial& trial) {
  const auto compute = [=](const Progress& progress) {
    const std::unique_ptr<Course> course = course_of(setup, trial);
    auto contenders = trial.has_all ? usual_contenders(leaf, course->lidar)
                                    : contenders_named({"static map", kEvermap}, leaf, course->lidar);
    const ContestRules rules{.leaf = leaf, .measurements = 6, .finds_poses = trial.finds_poses};
    return hold_contest(*course, std::move(contenders), rules, progress);
  };
  return {trial.name,
          {{"leaf", leaf},
           {"seed", trial.seed},
           {"scans", trial.scans},
           {"all", trial.has_all},
           {"finds_poses", trial.finds_poses}},
          compute};
}

Plot error_plot(const Json& result) {
  Plot plot{"Error of the pose", {"scan"}, {"distance [m]", true}, {}, {}, {}};
  const auto scans = result["scan_numbers"].get<std::vector<double>>();
  for (const std::string& name : contenders_of(result)) {
    plot.series.push_back({.name = name,
                           .x = scans,
                           .y = contender_of(result, name)->at("end")["error"].get<std::vector<double>>()});
  }
  return plot;
}

Plot quality_plot(const Json& result) {
  Plot plot{"AHD of the map", {"scan"}, {"distance [m]"}, {}, {}, {}};
  for (const std::string& name : contenders_of(result)) {
    plot.series.push_back({.name = name, .x = along(result, name, "scan"), .y = along(result, name, "AHD")});
  }
  return plot;
}

HtmlTable table_of(double leaf, const std::vector<Trial>& trials, const std::vector<Json>& results) {
  using Best = HtmlTable::Best;
  HtmlTable table{
      fmt::format("Localization in the map that is being kept, leaf {} m. ATE: without alignment. "
                  "Lost: share of scans off by more than 1 m or 5 degrees.",
                  leaf),
      {{"run", Best::kNone, 0}, {"map", Best::kNone, 0}},
      {}};
  const std::vector<std::string> measures{"ATE", "worst", "rotation", "lost", "tracked", "SA", "DA", "AHD"};
  const std::vector<std::string> titles{"ATE [m]", "worst [m]", "rotation [deg]", "lost", "tracked",
                                        "SA",      "DA",        "AHD [m]"};
  for (const std::string& title : titles) table.columns.push_back({title, Best::kNone, 4});
  for (std::size_t i = 0; i < trials.size(); ++i) {
    for (const std::string& name : contenders_of(results[i])) {
      std::vector<HtmlTable::Cell> row{trials[i].title, name};
      for (const std::string& measure : measures) row.emplace_back(at_end(results[i], name, measure));
      table.rows.push_back(std::move(row));
    }
  }
  return table;
}

void set_aims(Story& story, const Trial& trial, const Json& result) {
  const std::string& where = trial.title;
  aim_at_most(story, where, "ATE [m]", trial.is_real ? 0.1 : 0.03, at_end(result, kEvermap, "ATE"));
  if (!trial.is_real) aim_at_most(story, where, "rotation [deg]", 0.1, at_end(result, kEvermap, "rotation"));
  aim_at_most(story, where, "share lost", 0, at_end(result, kEvermap, "lost"));
}

}  // namespace

Experiment experiment_localization(const Setup& setup) {
  const double leaf = setup.leaves.empty() ? 0.4 : setup.leaves.front();
  const std::vector<Trial> trials = trials_of(setup);
  Experiment experiment{"localization", {}, {}, {}};
  const std::string missing = why_left_out(setup, kDrive);
  if (!setup.is_quick && !missing.empty()) experiment.left_out.push_back(missing);
  for (const Trial& trial : trials) experiment.units.push_back(unit_of(setup, leaf, trial));
  experiment.tell = [=](const std::vector<Json>& results, const std::filesystem::path& folder) {
    Story story{"Localization while the world changes"};
    story.blocks.emplace_back(Paragraph{
        "The pit of experiment C and the real drive of experiment A, but no map is given any pose but "
        "the first: each scan is registered against the map, and updates it there. Registration is the same "
        "for all; grids "
        "lend it a Gaussian for each occupied voxel, made of the voxels around."});
    write_plot(folder / "localization", {error_plot(results[0]), quality_plot(results[0])});
    story.blocks.emplace_back(Figure{"localization.svg",
                                     "The paper's figure 10: error of the pose, and how "
                                     "far map and truth are apart, over the scans."});
    story.blocks.emplace_back(table_of(leaf, trials, results));
    for (std::size_t i = 0; i < trials.size(); ++i) {
      if (trials[i].finds_poses) set_aims(story, trials[i], results[i]);
    }
    return story;
  };
  return experiment;
}

}  // namespace evermap
