// SPDX-FileCopyrightText: 2026 the evermap authors
// SPDX-License-Identifier: BSD-3-Clause
#include <algorithm>
#include <cmath>
#include <memory>
#include <numeric>

#include <fmt/format.h>

#include "experiments/experiment.hpp"
#include "experiments/race.hpp"
#include "plot.hpp"
#include <evermap/simulation/scenario_drive.hpp>

namespace evermap {
namespace {

/// OctoMap needs seconds a scan when leaves are small.
std::size_t scans_for(double leaf, bool is_quick) {
  const std::size_t scans = leaf < 0.15 ? 6 : leaf < 0.3 ? 12 : leaf < 0.5 ? 18 : 30;
  return is_quick ? std::max<std::size_t>(scans / 5, 3) : scans;
}

struct Times {
  double mean, deviation, median;  ///< [ms]
};

Times summarize(std::vector<double> seconds) {
  std::sort(seconds.begin(), seconds.end());
  const auto count = static_cast<double>(seconds.size());
  const double mean = std::accumulate(seconds.begin(), seconds.end(), 0.0) / count;
  double squares = 0;
  for (const double s : seconds) squares += (s - mean) * (s - mean);
  const double median = 0.5 * (seconds[(seconds.size() - 1) / 2] + seconds[seconds.size() / 2]);
  return {1e3 * mean, 1e3 * std::sqrt(squares / count), 1e3 * median};
}

Json compete(double leaf, std::size_t scans, std::uint64_t seed, const Progress& progress) {
  constexpr std::size_t kFirst = 100;  // scan of the scenario: the robot is under way
  Scenario scenario = shipped_scenario("quarry");
  scenario.seed = seed;
  const ScenarioDrive drive(scenario);
  std::vector<std::unique_ptr<Contender>> contenders;
  for (const std::string& name : contender_names()) {
    if (name != "static map") contenders.push_back(make_contender(name, leaf));
  }
  std::erase(contenders, nullptr);
  const Points survey = drive.survey(std::max(0.1, leaf / 4));
  for (const auto& contender : contenders) contender->start(survey);
  const auto seconds = race(contenders, scans, [&](std::size_t i) {
    progress(i + 1, scans);
    return AlignedScan{drive.scan(kFirst + i).scan, drive.T_map_sensor(kFirst + i)};
  });
  Json result = {{"scans", seconds[0].size()}, {"contenders", Json::array()}};
  for (std::size_t c = 0; c < contenders.size(); ++c) {
    const Times times = summarize(seconds[c]);
    result["contenders"].push_back({{"name", contenders[c]->name()},
                                    {"version", contenders[c]->version()},
                                    {"mean_ms", times.mean},
                                    {"deviation_ms", times.deviation},
                                    {"median_ms", times.median},
                                    {"memory_bytes", contenders[c]->memory_bytes()}});
  }
  return result;
}

double median_of(const Json& result, const std::string& name) {
  const Json* contender = contender_of(result, name);
  return contender != nullptr ? number((*contender)["median_ms"]) : NAN;
}

HtmlTable time_table(const std::vector<double>& leaves, const std::vector<Json>& results) {
  using Best = HtmlTable::Best;
  HtmlTable table{
      "CPU time of one scan, one thread, about 42,200 returns within 200 m, warm maps. A ratio above 1 is "
      "slower than OctoMap, "
      "fed all points; below 1, faster.",
      {{"leaf [m]", Best::kNone, 1},
       {"map", Best::kNone, 0},
       {"mean [ms]", Best::kNone, 1},
       {"deviation [ms]", Best::kNone, 1},
       {"median [ms]", Best::kNone, 1},
       {"x OctoMap", Best::kNone, 4},
       {"x OctoMap, voxel means", Best::kNone, 4},
       {"map [MB]", Best::kNone, 1},
       {"scans", Best::kNone, 0}},
      {}};
  for (std::size_t i = 0; i < leaves.size(); ++i) {
    for (const Json& c : results[i]["contenders"]) {
      const double median = number(c["median_ms"]);
      table.rows.push_back({leaves[i], c["name"].get<std::string>(), number(c["mean_ms"]),
                            number(c["deviation_ms"]), median, median / median_of(results[i], "OctoMap"),
                            median / median_of(results[i], "OctoMap, voxel means"),
                            1e-6 * number(c["memory_bytes"]), number(results[i]["scans"])});
    }
  }
  return table;
}

/// Of each leaf size the paper's ratio, and what stands beside it here.
HtmlTable paper_table(const std::vector<double>& leaves, const std::vector<Json>& results) {
  using Best = HtmlTable::Best;
  HtmlTable table{
      "Time relative to OctoMap, beside the paper's table II. The paper's OctoMap is 7 to 16 times as fast "
      "as ours, "
      "most likely because it was fed filtered scans, so both comparisons are given.",
      {{"leaf [m]", Best::kNone, 1},
       {"the paper", Best::kNone, 2},
       {"evermap paper", Best::kNone, 4},
       {"evermap default", Best::kNone, 4},
       {"evermap default x OctoMap, voxel means", Best::kNone, 4}},
      {}};
  const std::vector<std::pair<double, double>> published{{1.0, 1.94}, {0.8, 2.14}, {0.6, 2.0},
                                                         {0.4, 1.73}, {0.2, 0.87}, {0.1, 0.50}};
  for (std::size_t i = 0; i < leaves.size(); ++i) {
    const auto known = std::find_if(published.begin(), published.end(),
                                    [&](const auto& p) { return std::abs(p.first - leaves[i]) < 1e-9; });
    const double octomap = median_of(results[i], "OctoMap");
    table.rows.push_back(
        {leaves[i], known == published.end() ? NAN : known->second,
         median_of(results[i], "evermap paper") / octomap, median_of(results[i], "evermap default") / octomap,
         median_of(results[i], "evermap default") / median_of(results[i], "OctoMap, voxel means")});
  }
  return table;
}

Plot time_plot(const std::vector<double>& leaves, const std::vector<Json>& results, const std::string& field,
               double scale, const std::string& title, const std::string& label) {
  Plot plot{title,
            {.label = "leaf edge [m]", .is_logarithmic = true, .tics = leaves},
            {.label = label, .is_logarithmic = true},
            {},
            {},
            {}};
  for (std::size_t c = 0; c < results[0]["contenders"].size(); ++c) {
    Series series{.name = results[0]["contenders"][c]["name"].get<std::string>(), .x = leaves, .y = {}};
    for (const Json& result : results) series.y.push_back(scale * number(result["contenders"][c][field]));
    plot.series.push_back(std::move(series));
  }
  return plot;
}

}  // namespace

Experiment experiment_timing(const Setup& setup) {
  const std::vector<double> leaves = !setup.leaves.empty() ? setup.leaves
                                     : setup.is_quick      ? std::vector{1.0, 0.8}
                                                           : std::vector{1.0, 0.8, 0.6, 0.4, 0.2, 0.1};
  Experiment experiment{"timing", {}, {}, {}};
  for (const double leaf : leaves) {
    const std::size_t scans = scans_for(leaf, setup.is_quick);
    experiment.units.push_back(
        {fmt::format("timing_{}", leaf),
         {{"leaf", leaf}, {"scans", scans}, {"seed", setup.seed}},
         [=, seed = setup.seed](const Progress& progress) { return compete(leaf, scans, seed, progress); },
         /*is_timed=*/true});
  }
  experiment.tell = [=](const std::vector<Json>& results, const std::filesystem::path& folder) {
    Story story{"Time of a scan"};
    story.blocks.emplace_back(
        Paragraph{"The pit's scans again, in turns. A grid mapper writes each voxel along each ray; evermap "
                  "reads the occupied leaves that "
                  "rays meet, skips what is empty by whole bricks, and keeps surface alone."});
    write_plot(folder / "timing",
               {time_plot(leaves, results, "median_ms", 1, "CPU time", "median of a scan [ms]"),
                time_plot(leaves, results, "memory_bytes", 1e-6, "Memory", "map [MB]")});
    story.blocks.emplace_back(
        Figure{"timing.svg",
               "CPU time of a scan and the map's memory, over the leaf edge. Both axes are "
               "logarithmic."});
    story.blocks.emplace_back(paper_table(leaves, results));
    story.blocks.emplace_back(time_table(leaves, results));
    return story;
  };
  return experiment;
}

}  // namespace evermap
