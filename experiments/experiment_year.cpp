// SPDX-FileCopyrightText: 2026 the evermap authors
// SPDX-License-Identifier: BSD-3-Clause
#include <algorithm>
#include <utility>

#include <fmt/format.h>
#include <oneapi/tbb/parallel_for.h>
#include <oneapi/tbb/task_arena.h>

#include "cpu_time.hpp"
#include "experiments/closed_loop.hpp"
#include "experiments/experiment.hpp"
#include "experiments/metrics.hpp"
#include "experiments/scenario_dataset.hpp"
#include <evermap/simulation/changing_place.hpp>

namespace evermap {
namespace {

constexpr double kSame = 0.01;           ///< [m] a surface is where it was
constexpr double kTruthSpacing = 0.23;   ///< [m]
constexpr double kMemorySpacing = 0.25;  ///< [m] of what is gone

struct YearTrial {
  std::string_view place;
  std::uint64_t seed;
  int sessions;
  int scans;    ///< of a session
  double leaf;  ///< [m]
};

ScenarioDataset dataset_of(const YearTrial& trial, int nights) {
  const RandomDrive drive{.scans = trial.scans, .changed = 0.2};
  Scenario scenario = parse_scenario(fmt::format("{} after {} nights", trial.place, nights),
                                     changing_place(trial.place, trial.seed, nights, drive));
  scenario.motion_distortion = false;
  return {std::move(scenario),
          {.truth_spacing = kTruthSpacing, .area = {Eigen::Vector2d(-42, -34), Eigen::Vector2d(42, 34)}}};
}

/// What the sessions before could see, and what became of it.
class SeenSurface {
 public:
  explicit SeenSurface(Points survey) : standing_(std::move(survey)) {}

  /// Tells what stands as it did and what is gone, where today's rays could tell; then adds what is seen
  /// today.
  Changes follow(const Truth& truth, double leaf, const std::vector<ScanRays>& rays) {
    Points unchanged, gone, moved;
    const std::vector<double> of_standing = truth.distances(standing_);
    for (std::size_t i = 0; i < standing_.size(); ++i)
      (of_standing[i] <= kSame ? unchanged : moved).push_back(standing_[i]);
    past_.insert(past_.end(), moved.begin(), moved.end());
    past_ = thinned(past_, kMemorySpacing);
    const std::vector<double> of_past = truth.distances(past_);
    for (std::size_t i = 0; i < past_.size(); ++i) {
      if (of_past[i] > leaf / 2) gone.push_back(past_[i]);
    }
    standing_ = unchanged;
    standing_.insert(standing_.end(), truth.observed.begin(), truth.observed.end());
    standing_ = thinned(standing_, kTruthSpacing / 2);
    const VoxelGrid grid{.edge = leaf};
    return {contradictable(unchanged, grid, rays), contradictable(gone, grid, rays)};
  }

 private:
  Points standing_;  ///< [m] seen when it was last there, and there in the last session
  Points past_;      ///< [m] seen once; not there, or not quite, in the last session
};

/// One mapper's day: it localizes in the map that it was left with the evening before, and updates it.
Json drive(Mapper& mapper, const Dataset& dataset, double leaf) {
  const Pose start = dataset.scans().front().T_map_sensor;
  mapper.resume(start);
  ClosedLoop loop(mapper, leaf, start, dataset.lidar);
  std::vector<double> cpu;  // [s]
  for (std::size_t i = 0; i < dataset.scans().size(); ++i) {
    const AlignedScan& aligned = dataset.scans()[i];
    const double before = thread_cpu_seconds();
    loop.process(aligned.scan, dataset.time(i), std::nullopt, aligned.T_map_sensor);
    cpu.push_back(thread_cpu_seconds() - before);
  }
  Json row = loop.errors();
  row.erase("error");
  const auto middle = cpu.begin() + static_cast<std::ptrdiff_t>(cpu.size() / 2);
  std::nth_element(cpu.begin(), middle, cpu.end());
  row["cpu ms"] = 1000 * *middle;
  return row;
}

Json run_year(const YearTrial& trial, const Progress& progress) {
  Mappers mappers;
  Points survey;  // the points near the route, to tell how much of it is left
  {
    const ScenarioDataset first = dataset_of(trial, 0);
    mappers = usual_mappers(trial.leaf, first.lidar);
    std::erase(mappers, nullptr);
    survey = first.survey();
    oneapi::tbb::parallel_for(std::size_t{0}, mappers.size(),
                              [&](std::size_t i) { mappers[i]->start(survey); });
    survey = within(first.area, thinned(survey, kMemorySpacing));
  }
  SeenSurface seen(survey);
  std::vector<Json> results(mappers.size());
  for (std::size_t i = 0; i < mappers.size(); ++i)
    results[i] = {{"name", mappers[i]->name()}, {"version", mappers[i]->version()}, {"rows", Json::array()}};
  Json survey_left = Json::array();
  Json fresh_leaves = Json::array();
  for (int session = 1; session <= trial.sessions; ++session) {
    const ScenarioDataset dataset = dataset_of(trial, session);
    const Truth truth = dataset.truth(dataset.scans().size() - 1);
    const Changes changes = seen.follow(truth, trial.leaf, dataset.rays());
    const std::unique_ptr<Mapper> fresh = make_mapper("static map", trial.leaf, dataset.lidar);
    fresh->start(dataset.survey());
    fresh_leaves.push_back(fresh->surface().size());
    const std::vector<double> from_survey = truth.distances(survey);
    survey_left.push_back(
        static_cast<double>(std::count_if(from_survey.begin(), from_survey.end(),
                                          [](double distance) { return distance <= kTruthSpacing / 4; })) /
        static_cast<double>(survey.size()));
    oneapi::tbb::parallel_for(std::size_t{0}, mappers.size(), [&](std::size_t i) {
      Json row;
      // On one thread, whose time is told.
      oneapi::tbb::task_arena(1).execute([&] { row = drive(*mappers[i], dataset, trial.leaf); });
      const Points map = mappers[i]->surface();
      row.update(measure_surface(map, truth, dataset.area, trial.leaf));
      row.update(measure_changes(*mappers[i], changes, dataset.position_sigma));
      row["leaves"] = map.size();
      row["session"] = session;
      results[i]["rows"].push_back(std::move(row));
    });
    progress(static_cast<std::size_t>(session), static_cast<std::size_t>(trial.sessions));
  }
  for (Json& result : results) result["end"] = result["rows"].back();
  return {{"mappers", results}, {"survey left", survey_left}, {"fresh leaves", fresh_leaves}};
}

}  // namespace

Experiment experiment_year(const Setup& setup) {
  Experiment experiment{"year"};
  for (const std::string_view place : kChangingPlaces) {
    const YearTrial trial{.place = place,
                          .seed = setup.seed,
                          .sessions = setup.is_quick ? 3 : 40,
                          .scans = setup.is_quick ? 40 : 170,
                          .leaf = setup.leaves.empty() ? 0.4 : setup.leaves.front()};
    std::string name = fmt::format("year_{}", place);
    std::replace(name.begin(), name.end(), ' ', '_');
    experiment.units.push_back({name,
                                std::string(place),
                                {{"place", place},
                                 {"seed", trial.seed},
                                 {"sessions", trial.sessions},
                                 {"scans", trial.scans},
                                 {"leaf", trial.leaf}},
                                [trial](const Progress& progress) { return run_year(trial, progress); }});
  }
  return experiment;
}

}  // namespace evermap
