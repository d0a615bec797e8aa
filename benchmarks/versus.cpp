// SPDX-FileCopyrightText: 2026 the evermap authors
// SPDX-License-Identifier: BSD-3-Clause
// How long a scan takes in evermap and in other maps: the same scans of the quarry, or of a real drive, one
// thread, CPU time, in turns, from the map of the survey and from empty maps.
#include <algorithm>
#include <functional>
#include <memory>
#include <stdexcept>
#include <string>
#include <vector>

#include <CLI/CLI.hpp>
#include <fmt/core.h>

#include "drive.hpp"
#include "experiments/machine.hpp"
#include "experiments/outdated_drive.hpp"
#include "experiments/result_file.hpp"
#include "experiments/timed_turns.hpp"

namespace evermap {
namespace {

struct Options {
  std::vector<double> leaves{1.0, 0.8, 0.6, 0.4, 0.2, 0.1};  ///< [m]
  std::vector<std::string> against{"OctoMap", "OctoMap, voxel means"};
  std::size_t scans = 0;  ///< 0: as many as `default_scans`
  std::string data;       ///< a folder such as kitti_0005_drive; empty: the scenario quarry
  std::string json;
};

/// What is driven through, and the survey [m] that a map of leaves of `edge` [m] begins with.
struct Place {
  std::string description;
  Drive drive;
  std::function<Points(double edge)> survey;
};

struct Times {
  double median;     ///< [ms] a scan
  double low, high;  ///< [ms] 10 % and 90 % of the scans are faster
};

struct Result {
  std::string name;
  Times times;
  std::size_t memory_bytes;
};

constexpr std::size_t kMostScans = 60;
/// OctoMap needs seconds a scan when leaves are small.
std::size_t default_scans(double leaf) { return leaf < 0.15 ? 15 : leaf < 0.3 ? 30 : kMostScans; }

Times summarize(std::vector<double> seconds) {
  std::sort(seconds.begin(), seconds.end());
  const auto at = [&](double fraction) {
    return 1e3 * seconds[static_cast<std::size_t>(fraction * static_cast<double>(seconds.size() - 1) + 0.5)];
  };
  return {at(0.5), at(0.1), at(0.9)};
}

/// They begin with the survey, or, when it is empty, with empty maps.
Mappers mappers_of(const std::vector<std::string>& against, double leaf, const Points& survey) {
  std::vector<std::string> names{"evermap default", "evermap paper"};
  names.insert(names.end(), against.begin(), against.end());
  Mappers mappers = mappers_named(names, leaf, {});
  for (std::size_t i = 0; i < mappers.size(); ++i) {
    if (!mappers[i]) throw std::runtime_error(names[i] + " was not found when evermap was built");
    mappers[i]->start(survey);
  }
  return mappers;
}

Place quarry(std::size_t scans) {
  const auto quarry = std::make_shared<ScenarioDrive>(shipped_scenario("quarry"));
  return {"scenario quarry, 64 x 1024 beams, some 42,000 returns a scan, 200 m range",
          drive_through_quarry(scans),
          [quarry](double edge) { return quarry->survey(std::max(0.1, edge / 4)); }};
}

Place real_drive(const std::string& folder, std::size_t scans) {
  const OutdatedDrive drive(folder, scans);
  Place place{folder, {}, [survey = drive.survey()](double /*edge*/) { return survey; }};
  for (const AlignedScan& aligned : drive.scans()) {
    place.drive.scans.push_back(aligned.scan);
    place.drive.T_map_sensor.push_back(aligned.T_map_sensor);
  }
  return place;
}

std::vector<Result> time_mappers(const Mappers& mappers, const Drive& drive, std::size_t scans) {
  const auto seconds = time_in_turns(mappers, scans, [&](std::size_t scan) {
    return AlignedScan{drive.scans[scan], drive.T_map_sensor[scan]};
  });
  std::vector<Result> results;
  for (std::size_t c = 0; c < mappers.size(); ++c) {
    results.push_back({mappers[c]->name(), summarize(seconds[c]), mappers[c]->memory_bytes()});
  }
  return results;
}

Json describe(const Place& place) {
  return {{"cpu", processor()},
          {"compiler", compiler()},
          {"flags", EVERMAP_FLAGS},
          {"evermap", EVERMAP_VERSION},
          {"octomap", make_mapper("OctoMap", 1)->version()},
          {"threads", 1},
          {"clock", "CPU time of the process"},
          {"data", place.description}};
}

void print(double leaf, const char* start, std::size_t scans, const std::vector<Result>& results) {
  const Result& reference = results[2];
  for (const Result& r : results) {
    fmt::print("{:4.1f} {:6} {:6} {:20} {:9.2f} {:9.2f} {:9.2f} {:10.1f} {:10.1f} {:10.1f}\n", leaf, start,
               scans, r.name, r.times.median, r.times.low, r.times.high,
               reference.times.median / r.times.median, static_cast<double>(r.memory_bytes) / 1e6,
               static_cast<double>(reference.memory_bytes) / static_cast<double>(r.memory_bytes));
  }
  std::fflush(stdout);  // the next leaf size may take minutes
}

Json to_json(double leaf, const char* start, std::size_t scans, const std::vector<Result>& results) {
  Json json = {{"leaf_m", leaf}, {"start", start}, {"scans", scans}, {"mappers", Json::array()}};
  for (const Result& r : results) {
    json["mappers"].push_back({{"name", r.name},
                               {"median_ms", r.times.median},
                               {"p10_ms", r.times.low},
                               {"p90_ms", r.times.high},
                               {"ratio", results[2].times.median / r.times.median},
                               {"memory_bytes", r.memory_bytes}});
  }
  return json;
}

void run_all(const Options& options) {
  const std::size_t most = std::max(options.scans, kMostScans);
  const Place place = options.data.empty() ? quarry(most) : real_drive(options.data, most);
  Json report = describe(place);
  for (const auto& [key, value] : report.items()) fmt::print("{:9} {}\n", key, value.dump());
  constexpr const char* kHead = "{:>4} {:6} {:>6} {:20} {:>9} {:>9} {:>9} {:>10} {:>10} {:>10}\n";
  fmt::print("\n");
  fmt::print(kHead, "leaf", "from", "scans", "", "median", "10 %", "90 %", "faster by", "map", "smaller by");
  fmt::print(kHead, "[m]", "", "", "", "[ms]", "[ms]", "[ms]", "", "[MB]", "");
  for (const double leaf : options.leaves) {
    const std::size_t scans = options.scans > 0 ? options.scans : default_scans(leaf);
    for (const bool has_survey : {true, false}) {
      const char* start = has_survey ? "survey" : "empty";
      const Points survey = has_survey ? place.survey(leaf) : Points{};
      const std::vector<Result> results =
          time_mappers(mappers_of(options.against, leaf, survey), place.drive, scans);
      print(leaf, start, scans, results);
      report["leaves"].push_back(to_json(leaf, start, scans, results));
    }
  }
  if (options.json.empty()) return;
  write_file(options.json, dump(report));
}

}  // namespace
}  // namespace evermap

int main(int argc, char** argv) {
  evermap::Options options;
  CLI::App app("Times evermap and other maps on the same scans, one thread, CPU time");
  app.add_option("--leaf", options.leaves, "Leaf edges")->type_name("METRES")->check(CLI::Range(0.05, 2.0));
  app.add_option("--against", options.against, "Mappers; the first is what ratios are taken to")
      ->check(CLI::IsMember(evermap::mapper_names()))
      ->capture_default_str();
  app.add_option("--scans", options.scans, "Scans of the drive; the first third is not counted")
      ->check(CLI::Range(3, 1000));
  app.add_option("--data", options.data, "A real drive with labelled boxes instead of the quarry")
      ->type_name("DIR")
      ->check(CLI::ExistingDirectory);
  app.add_option("--json", options.json, "Also write the figures to this file");
  CLI11_PARSE(app, argc, argv);

  try {
    evermap::run_all(options);
  } catch (const std::exception& error) {
    fmt::print(stderr, "bench_versus: {}\n", error.what());
    return 1;
  }
}
