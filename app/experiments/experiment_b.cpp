// SPDX-FileCopyrightText: 2026 the evermap authors
// SPDX-License-Identifier: BSD-3-Clause
#include <algorithm>
#include <cmath>
#include <optional>

#include <fmt/format.h>

#include "experiments/contest_story.hpp"
#include "experiments/experiment.hpp"
#include "experiments/redlight_course.hpp"
#include "experiments/scenario_course.hpp"

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
    const ScenarioCourse course(choice, seed);
    return hold_contest(course, usual_contenders(leaf, course.lidar),
                        {.leaf = leaf, .measurements = measurements, .has_picture = true}, progress);
  };
  return {fmt::format("b_passing_{}", leaf),
          {{"leaf", leaf}, {"seed", setup.seed}, {"every", choice.every}, {"measurements", measurements}},
          compute};
}

Unit redlight(const Setup& setup, double leaf) {
  const auto compute = [=, folder = setup.data / kRedlight](const Progress& progress) {
    const RedlightCourse course(folder);
    return hold_contest(course, usual_contenders(leaf, course.lidar),
                        {.leaf = leaf, .measurements = 22, .has_picture = true}, progress);
  };
  return {fmt::format("b_redlight_{}", leaf), {{"leaf", leaf}}, compute};
}

/// A time in which something passes, in numbers of scans.
struct Passage {
  std::string name;
  double from, to;
};

/// When each passer was in view. What each contender shows of it is null when it was not.
std::vector<Passage> passages_of(const Json& result) {
  std::vector<Passage> passages;
  const Json& shown = result["contenders"][0].value("shown", Json::object());
  for (const auto& [name, shares] : shown.items()) {
    std::optional<Passage> passage;
    for (std::size_t i = 0; i < shares.size(); ++i) {
      if (shares[i].is_null()) continue;
      const double scan = number(result["scan_numbers"][i]);
      if (!passage) passage = {name, scan, scan};
      passage->to = scan;
    }
    if (passage) passages.push_back(*passage);
  }
  std::sort(passages.begin(), passages.end(),
            [](const Passage& a, const Passage& b) { return a.from < b.from; });
  return passages;
}

/// What a map said of a passer ("shown" or "noticed").
struct Appearance {
  double mean_share;  ///< of its points in the scan just taken
  double scans;       ///< until any of them; NaN when there never was
};

Appearance appearance(const Json& contender, const char* said, const Passage& passage) {
  double sum = 0;
  double count = 0;
  double until = NAN;
  for (const Json& share : contender.at(said).at(passage.name)) {
    if (share.is_null()) continue;
    ++count;
    sum += number(share);
    if (std::isnan(until) && number(share) > 0) until = count;
  }
  return {sum / count, until};
}

/// What a contender showed of what passed, and how the map recovered.
HtmlTable passage_table(const Json& result, const std::vector<Passage>& passages,
                        const std::string& caption) {
  using Best = HtmlTable::Best;
  HtmlTable table{caption, {{"map", Best::kNone, 0}}, {}};
  for (const Passage& passage : passages) {
    table.columns.push_back({fmt::format("{}: shown, mean", passage.name), Best::kNone, 3});
    table.columns.push_back({"scans until shown", Best::kNone, 0});
    table.columns.push_back({"noticed, mean", Best::kNone, 3});
  }
  table.columns.insert(table.columns.end(), {{"least ACC l", Best::kHighest, 4},
                                             {"ACC l, last", Best::kHighest, 4},
                                             {"COV l, first", Best::kHighest, 4},
                                             {"COV l, last", Best::kHighest, 4}});
  for (const Json& contender : result["contenders"]) {
    std::vector<HtmlTable::Cell> row{contender["name"].get<std::string>()};
    for (const Passage& passage : passages) {
      const Appearance shown = appearance(contender, "shown", passage);
      row.emplace_back(shown.mean_share);
      row.emplace_back(shown.scans);
      row.emplace_back(appearance(contender, "noticed", passage).mean_share);
    }
    const std::string name = contender["name"];
    const std::vector<double> accuracy = along(result, name, "ACC l");
    const std::vector<double> coverage = along(result, name, "COV l");
    row.insert(row.end(), {*std::min_element(accuracy.begin(), accuracy.end()), accuracy.back(),
                           coverage.front(), coverage.back()});
    table.rows.push_back(std::move(row));
  }
  return table;
}

/// Value of the first measurement that is at or after a scan; of the last one when there is none.
double value_after(const Json& result, const std::string& measure, double scan) {
  const std::vector<double> numbers = along(result, kEvermap, "scan");
  const std::vector<double> values = along(result, kEvermap, measure);
  const auto found = std::lower_bound(numbers.begin(), numbers.end(), scan);
  return found == numbers.end() ? values.back() : values[static_cast<std::size_t>(found - numbers.begin())];
}

void set_aims(Story& story, const std::string& data, const Json& result,
              const std::vector<Passage>& passages) {
  double last = 0;
  for (const Passage& passage : passages) last = std::max(last, passage.to);
  const double start = along(result, kEvermap, "COV l").front();
  const bool is_over = last < number(result["scan_numbers"].back());
  const std::string when = is_over ? "10 scans after the last passer" : "at the end, traffic still passing";
  const double scan = is_over ? last + 10 : last;
  aim_at_least(story, data, "ACC l, " + when, 0.999, value_after(result, "ACC l", scan));
  aim_at_least(story, data, "COV l as a share of the first, " + when, 0.999,
               value_after(result, "COV l", scan) / start);
  for (const Passage& passage : passages) {
    aim_at_most(story, data, "scans until noticed: " + passage.name, 3,
                appearance(*contender_of(result, kEvermap), "noticed", passage).scans);
  }
}

}  // namespace

Experiment experiment_b(const Setup& setup) {
  const std::vector<double> leaves =
      setup.leaves.empty() ? std::vector{setup.is_quick ? 0.4 : 0.2} : setup.leaves;
  Experiment experiment{"b", {}, {}, {}};
  const std::string missing = why_left_out(setup, kRedlight);
  if (!missing.empty()) experiment.left_out.push_back(missing);
  for (const double leaf : leaves) {
    experiment.units.push_back(passing(setup, leaf));
    if (missing.empty()) experiment.units.push_back(redlight(setup, leaf));
  }
  experiment.tell = [=, units = experiment.units](const std::vector<Json>& results,
                                                  const std::filesystem::path& folder) {
    Story story{"B: standing still while others pass"};
    story.blocks.emplace_back(
        Paragraph{"The map is up to date, the robot stands, and others pass. A map is good when no trace of "
                  "them is left and nothing of "
                  "the street is lost, however often the same rays hit it. In the paper, ACC falls with each "
                  "passage and comes back "
                  "to almost 100 %. A passer that never stays in one voxel for three scans is never taken "
                  "for surface by evermap: "
                  "there is nothing to take back. It is noticed all the same: its leaves are pending, in the "
                  "map file, too."});
    for (std::size_t i = 0; i < results.size(); ++i) {
      const bool is_real = units[i].name.starts_with("b_redlight");
      const double leaf = units[i].settings["leaf"];
      const std::string data =
          fmt::format("{}, leaf {} m", is_real ? "real red light (KITTI)" : "simulated standstill", leaf);
      const std::vector<Passage> passages = passages_of(results[i]);
      Telling telling{
          .curves = {{"ACC l", "ACC within l"}, {"COV l", "COV within l"}},
          .figure =
              "The paper's figure 8: the share of the map that is true, with passages in grey, and the "
              "share of the truth that the map covers",
          .view = "The street from above at the end"};
      for (const Passage& p : passages) telling.shaded.push_back({p.from, p.to, p.name});
      tell_contest(story, folder, units[i].name, data, results[i], telling);
      set_aims(story, data, results[i], passages);
      story.blocks.emplace_back(passage_table(
          results[i], passages,
          fmt::format(
              "What the map showed of what passed (share of its points in the scan just taken), what it "
              "noticed (pending leaves, too), and what it came to: {}",
              data)));
    }
    return story;
  };
  return experiment;
}

}  // namespace evermap
