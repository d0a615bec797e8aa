// SPDX-FileCopyrightText: 2026 the evermap authors
// SPDX-License-Identifier: BSD-3-Clause
#include <algorithm>
#include <cmath>
#include <numeric>

#include <fmt/format.h>

#include "experiments/experiment.hpp"
#include "experiments/timed_turns.hpp"
#include <evermap/simulation/scenario_drive.hpp>

namespace evermap {
namespace {

/// OctoMap needs seconds a scan when leaves are small.
std::size_t scans_for(double leaf, bool is_quick) {
  const std::size_t scans = leaf < 0.15 ? 6 : leaf < 0.3 ? 12 : leaf < 0.5 ? 18 : 30;
  return is_quick ? std::max<std::size_t>(scans / 5, 3) : scans;
}

Json summarize(std::vector<double> seconds) {
  std::sort(seconds.begin(), seconds.end());
  const auto count = static_cast<double>(seconds.size());
  const double mean = std::accumulate(seconds.begin(), seconds.end(), 0.0) / count;
  double squares = 0;
  for (const double s : seconds) squares += (s - mean) * (s - mean);
  const double median = 0.5 * (seconds[(seconds.size() - 1) / 2] + seconds[seconds.size() / 2]);
  return {{"mean_ms", 1e3 * mean},
          {"deviation_ms", 1e3 * std::sqrt(squares / count)},
          {"median_ms", 1e3 * median}};
}

Json time_mappers(double leaf, std::size_t scans, bool has_survey, std::uint64_t seed,
                  const Progress& progress) {
  constexpr std::size_t kFirst = 100;  // scan of the scenario: the robot is under way
  Scenario scenario = shipped_scenario("quarry");
  scenario.seed = seed;
  const ScenarioDrive drive(scenario);
  std::vector<std::string> names = mapper_names();
  std::erase(names, "static map");
  Mappers mappers = mappers_named(names, leaf, {});
  std::erase(mappers, nullptr);
  if (has_survey) {
    const Points survey = drive.survey(std::max(0.1, leaf / 4));
    for (const auto& mapper : mappers) mapper->start(survey);
  }
  std::size_t points = 0;
  const auto seconds = time_in_turns(mappers, scans, [&](std::size_t i) {
    progress(i + 1, scans);
    AlignedScan aligned{drive.scan(kFirst + i).scan, drive.T_map_sensor(kFirst + i)};
    points += aligned.scan.p_sensor.size();
    return aligned;
  });
  Json result = {
      {"scans", seconds[0].size()}, {"points_per_scan", points / scans}, {"mappers", Json::array()}};
  for (std::size_t m = 0; m < mappers.size(); ++m) {
    Json& mapper = result["mappers"].emplace_back(
        Json{{"name", mappers[m]->name()}, {"version", mappers[m]->version()}});
    mapper.update(summarize(seconds[m]));
    mapper["memory_bytes"] = mappers[m]->memory_bytes();
  }
  return result;
}

Unit unit_of(const Setup& setup, double leaf, bool has_survey) {
  const std::size_t scans = scans_for(leaf, setup.is_quick);
  return {
      fmt::format("timing_{}{}", leaf, has_survey ? "" : "_empty"),
      fmt::format("leaf {} m, {}", leaf, has_survey ? "from the survey" : "from empty maps"),
      {{"leaf", leaf}, {"scans", scans}, {"start", has_survey ? "survey" : "empty"}, {"seed", setup.seed}},
      [=, seed = setup.seed](const Progress& progress) {
        return time_mappers(leaf, scans, has_survey, seed, progress);
      },
      /*is_timed=*/true};
}

}  // namespace

Experiment experiment_timing(const Setup& setup) {
  const std::vector<double> leaves = !setup.leaves.empty() ? setup.leaves
                                     : setup.is_quick      ? std::vector{1.0, 0.8}
                                                           : std::vector{1.0, 0.8, 0.6, 0.4, 0.2, 0.1};
  Experiment experiment{"timing"};
  for (const double leaf : leaves) {
    for (const bool has_survey : {true, false}) {
      experiment.units.push_back(unit_of(setup, leaf, has_survey));
    }
  }
  return experiment;
}

}  // namespace evermap
