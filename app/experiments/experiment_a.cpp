// SPDX-FileCopyrightText: 2026 the evermap authors
// SPDX-License-Identifier: BSD-3-Clause
#include <fmt/format.h>

#include "experiments/contest_story.hpp"
#include "experiments/experiment.hpp"
#include "experiments/outdated_drive.hpp"
#include "experiments/scenario_course.hpp"

namespace evermap {
namespace {

ContestRules rules_for(const Setup& setup, double leaf) {
  return {.leaf = leaf, .measurements = setup.is_quick ? 3U : 11U, .has_picture = true};
}

Unit street(const Setup& setup, double leaf) {
  const ScenarioChoice choice{.scenario = "street",
                              .scans = setup.is_quick ? 16 : 220,
                              .survey_spacing = leaf < 0.3 ? 0.05 : 0.1,
                              .truth_spacing = setup.is_quick ? 0.31 : 0.17,
                              .area = {Eigen::Vector2d(-105, -40), Eigen::Vector2d(105, 40)},
                              .view = {Eigen::Vector2d(-75, -13), Eigen::Vector2d(75, 13)}};
  const ContestRules rules = rules_for(setup, leaf);
  const auto compute = [=, seed = setup.seed](const Progress& progress) {
    const ScenarioCourse course(choice, seed);
    return hold_contest(course, usual_contenders(leaf, course.lidar), rules, progress);
  };
  return {fmt::format("a_street_{}", leaf),
          {{"leaf", leaf},
           {"seed", setup.seed},
           {"scans", *choice.scans},
           {"truth_spacing", choice.truth_spacing}},
          compute};
}

Unit real_drive(const Setup& setup, double leaf) {
  const std::size_t scans = setup.is_quick ? 8 : 80;
  const ContestRules rules = rules_for(setup, leaf);
  const auto compute = [=, folder = setup.data / kDrive](const Progress& progress) {
    const OutdatedDrive course(folder, scans);
    return hold_contest(course, usual_contenders(leaf, course.lidar), rules, progress);
  };
  return {fmt::format("a_drive_{}", leaf), {{"leaf", leaf}, {"scans", scans}}, compute};
}

Telling telling(const std::string& view) {
  return {
      .curves = {{"COV 0.1", "COV within 0.1 m"}, {"COV 0.2", "COV within 0.2 m"}, {"AHD", "AHD", true}},
      .figure =
          "The paper's figure 6: how much of the true surface the map covers, and how far the two are apart",
      .view = view};
}

void set_aims(Story& story, const std::string& data, const Json& result) {
  aim_at_least(story, data, "SA", 0.997, at_end(result, kEvermap, "SA"));
  aim_at_least(story, data, "DA", 0.98, at_end(result, kEvermap, "DA"));
  aim_at_most(story, data, "largest sag of COV 0.2 during the run", 0.001,
              largest_sag(along(result, kEvermap, "COV 0.2")));
  for (const char* measure : {"COV 0.1", "COV 0.2", "COV 0.5"}) {
    const bool best = is_best(result, measure, true);
    story.aims.push_back({data, fmt::format("{} highest of all", measure), best ? "yes" : "no", best});
  }
  const bool best = is_best(result, "AHD", false);
  story.aims.push_back({data, "AHD lowest of all", best ? "yes" : "no", best});
}

}  // namespace

Experiment experiment_a(const Setup& setup) {
  const std::vector<double> leaves = leaves_of(setup);
  Experiment experiment{"a", {}, {}, {}};
  const std::string missing = why_left_out(setup, kDrive);
  if (!missing.empty()) experiment.left_out.push_back(missing);
  for (const double leaf : leaves) {
    experiment.units.push_back(street(setup, leaf));
    if (missing.empty()) experiment.units.push_back(real_drive(setup, leaf));
  }
  experiment.tell = [=, units = experiment.units](const std::vector<Json>& results,
                                                  const std::filesystem::path& folder) {
    Story story{"A: driving with a map that is out of date"};
    story.blocks.emplace_back(
        Paragraph{"Since the survey, parked vehicles have come, gone or shifted by 0.3 m, and 10 m of verge "
                  "were 0.3 m higher. During the "
                  "drive nothing changes for good. A map is good when it takes up what has come, drops what "
                  "is gone, and keeps the "
                  "road whole: a grid mapper looks along the road at a flat angle and erases it. In the "
                  "paper's own drive, coverage "
                  "rises to 83.5 % and OctoMap's sags."});
    for (std::size_t i = 0; i < results.size(); ++i) {
      const bool is_real = units[i].name.starts_with("a_drive");
      const double leaf = units[i].settings["leaf"];
      const std::string data =
          fmt::format("{}, leaf {} m", is_real ? "real drive (KITTI)" : "simulated street", leaf);
      tell_contest(
          story, folder, units[i].name, data, results[i],
          telling("The paper's figure 5: the road and what stands beside it, from above at the end"));
      set_aims(story, data, results[i]);
    }
    return story;
  };
  return experiment;
}

}  // namespace evermap
