// SPDX-FileCopyrightText: 2026 the evermap authors
// SPDX-License-Identifier: BSD-3-Clause
#include <algorithm>
#include <memory>
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
  SeenSurface() = default;
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

/// One mapper's day: it localizes in the map that it was left with the evening before, and updates it. A
/// robot that has been lost for two seconds waits for help.
Json drive(Mapper& mapper, const Dataset& dataset, double leaf) {
  const Pose start = dataset.scans().front().T_map_sensor;
  mapper.resume(start);
  ClosedLoop loop(mapper, leaf, start, dataset.lidar);
  std::vector<double> cpu;  // [s]
  for (std::size_t i = 0; i < dataset.scans().size(); ++i) {
    constexpr std::size_t kGivesUp = 20;  // scans
    const AlignedScan& aligned = dataset.scans()[i];
    if (loop.lost_lately() >= kGivesUp) {
      loop.stand_lost(aligned.T_map_sensor);
      continue;
    }
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

/// A year of mappers at a place.
class Year {
 public:
  explicit Year(const YearTrial& trial) : trial_(trial) {
    const ScenarioDataset first = dataset_of(trial, 0);
    mappers_ = usual_mappers(trial.leaf, first.lidar);
    std::erase(mappers_, nullptr);
    const Points survey = first.survey();
    results_.resize(mappers_.size());
    oneapi::tbb::parallel_for(std::size_t{0}, mappers_.size(), [&](std::size_t i) {
      mappers_[i]->start(survey);
      results_[i] = {
          {"name", mappers_[i]->name()}, {"version", mappers_[i]->version()}, {"rows", Json::array()}};
    });
    survey_ = within(first.area, thinned(survey, kMemorySpacing));
    seen_ = SeenSurface(survey_);
  }

  void drive_session(int session) {
    const ScenarioDataset dataset = dataset_of(trial_, session);
    const Truth truth = dataset.truth(dataset.scans().size() - 1);
    note_place(dataset, truth);
    const Changes changes = seen_.follow(truth, trial_.leaf, dataset.rays());
    oneapi::tbb::parallel_for(std::size_t{0}, mappers_.size(), [&](std::size_t i) {
      Json row;
      // On one thread, whose time is told.
      oneapi::tbb::task_arena(1).execute([&] { row = drive(*mappers_[i], dataset, trial_.leaf); });
      const Points map = mappers_[i]->surface();
      row.update(measure_surface(map, truth, dataset.area, trial_.leaf));
      row.update(measure_changes(*mappers_[i], changes, dataset.position_sigma));
      row["leaves"] = map.size();
      row["session"] = session;
      results_[i]["rows"].push_back(std::move(row));
    });
  }

  Json finish() {
    for (Json& result : results_) result["end"] = result["rows"].back();
    return {{"mappers", results_}, {"survey left", survey_left_}, {"fresh leaves", fresh_leaves_}};
  }

 private:
  /// How much of the first survey is left around the route, and how large a map of today's would be.
  void note_place(const ScenarioDataset& dataset, const Truth& truth) {
    constexpr double kLeft = kTruthSpacing / 4;  // [m]
    const std::unique_ptr<Mapper> fresh = make_mapper("static map", trial_.leaf, dataset.lidar);
    fresh->start(dataset.survey());
    fresh_leaves_.push_back(fresh->surface().size());
    const std::vector<double> distances = truth.distances(survey_);
    const auto left = std::count_if(distances.begin(), distances.end(), [](double d) { return d <= kLeft; });
    survey_left_.push_back(static_cast<double>(left) / static_cast<double>(survey_.size()));
  }

  YearTrial trial_;
  Mappers mappers_;
  Points survey_;  ///< [m] around the route, thinned
  SeenSurface seen_;
  std::vector<Json> results_;
  Json survey_left_ = Json::array();
  Json fresh_leaves_ = Json::array();
};

Json run_year(const YearTrial& trial, const Progress& progress) {
  Year year(trial);
  for (int session = 1; session <= trial.sessions; ++session) {
    year.drive_session(session);
    progress(static_cast<std::size_t>(session), static_cast<std::size_t>(trial.sessions));
  }
  return year.finish();
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
