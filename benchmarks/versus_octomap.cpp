// SPDX-FileCopyrightText: 2026 the evermap authors
// SPDX-License-Identifier: BSD-3-Clause
// How long a scan takes in evermap and in OctoMap: the same scans of the same yard, one thread, CPU time. The
// contenders take turns scan by scan, so that whatever else the machine does meets all of them alike.
#include <algorithm>
#include <ctime>
#include <fstream>
#include <functional>
#include <string>
#include <utility>
#include <vector>

#include <CLI/CLI.hpp>
#include <fmt/core.h>
#include <nlohmann/json.hpp>
#include <oneapi/tbb/global_control.h>

#include "drive.hpp"
#include <evermap/evaluation/octomap_baseline.hpp>

namespace evermap {
namespace {

struct Options {
  std::vector<double> leaves{1.0, 0.8, 0.6, 0.4, 0.2, 0.1};  ///< [m]
  std::size_t scans = 0;                                     ///< 0: as many as `default_scans`
  std::string json;
};

/// What is timed: one way to bring a map up to date.
struct Contender {
  std::string name;
  std::function<void(std::size_t scan)> insert;
  std::function<std::size_t()> memory_bytes;
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

/// OctoMap needs seconds a scan when leaves are small.
std::size_t default_scans(double leaf) { return leaf < 0.15 ? 15 : leaf < 0.3 ? 30 : 60; }

double cpu_milliseconds() {
  timespec now{};
  clock_gettime(CLOCK_PROCESS_CPUTIME_ID, &now);
  return 1e3 * static_cast<double>(now.tv_sec) + 1e-6 * static_cast<double>(now.tv_nsec);
}

Times summarize(std::vector<double> milliseconds) {
  std::sort(milliseconds.begin(), milliseconds.end());
  const auto at = [&](double share) {
    return milliseconds[static_cast<std::size_t>(share * static_cast<double>(milliseconds.size() - 1) + 0.5)];
  };
  return {at(0.5), at(0.1), at(0.9)};
}

std::vector<Result> compete(const std::vector<Contender>& contenders, std::size_t scans) {
  std::vector<std::vector<double>> milliseconds(contenders.size());
  for (std::size_t scan = 0; scan < scans; ++scan) {
    for (std::size_t c = 0; c < contenders.size(); ++c) {
      const double begin = cpu_milliseconds();
      contenders[c].insert(scan);
      const double time = cpu_milliseconds() - begin;
      const bool warm = 3 * scan >= scans;  // in the first third the maps still learn the yard
      if (warm) milliseconds[c].push_back(time);
    }
  }
  std::vector<Result> results;
  for (std::size_t c = 0; c < contenders.size(); ++c) {
    results.push_back({contenders[c].name, summarize(milliseconds[c]), contenders[c].memory_bytes()});
  }
  return results;
}

/// The scans as OctoMap takes them: points in the map frame, all of them or the mean of each voxel's.
struct MapFrameScans {
  std::vector<Points> all;
  std::vector<Points> bundle_means;

  MapFrameScans(const Drive& drive, const VoxelGrid& grid) {
    for (std::size_t i = 0; i < drive.scans.size(); ++i) {
      const Pose& T_map_sensor = drive.T_map_sensor[i];
      Points points;
      for (const Eigen::Vector3d& p_sensor : drive.scans[i].p_sensor)
        points.push_back(T_map_sensor * p_sensor);
      all.push_back(std::move(points));
      Points means;
      const BundleGrid bundles = condense(drive.scans[i], T_map_sensor, grid, {});
      for (const RayBundle& bundle : bundles.bundles()) means.push_back(bundle.points.mean);
      bundle_means.push_back(std::move(means));
    }
  }
};

Contender evermap_contender(std::string name, Octree& octree, const Drive& drive,
                            const UpdateParameters& parameters) {
  return {std::move(name),
          [&octree, &drive, parameters](std::size_t i) {
            update(octree, drive.scans[i], drive.T_map_sensor[i], parameters);
          },
          [&octree] { return octree.memory_bytes(); }};
}

Contender octomap_contender(std::string name, OctoMapBaseline& map, const Drive& drive,
                            const std::vector<Points>& scans) {
  constexpr double kNoLimit = -1;
  return {std::move(name),
          [&](std::size_t i) { map.insert_scan(drive.T_map_sensor[i].translation, scans[i], kNoLimit); },
          [&map] { return map.memory_bytes(); }};
}

/// All contenders start from the same survey of the yard as it was, and see the drive through it as it is.
std::vector<Result> run(double leaf, std::size_t scans) {
  const Yard yard = make_yard();
  const Drive drive = drive_through(yard, yard.now, scans);
  const Points survey = survey_of(yard.before);
  Octree default_map = map_of(survey, leaf);
  Octree paper_map = default_map;
  OctoMapBaseline all_map(leaf);
  OctoMapBaseline means_map(leaf);
  all_map.insert_surface(survey);
  means_map.insert_surface(survey);
  const MapFrameScans points(drive, default_map.grid());
  return compete({evermap_contender("evermap default", default_map, drive, {}),
                  evermap_contender("evermap paper", paper_map, drive, UpdateParameters::paper()),
                  octomap_contender("OctoMap all points", all_map, drive, points.all),
                  octomap_contender("OctoMap voxel means", means_map, drive, points.bundle_means)},
                 scans);
}

std::string cpu_model() {
  std::ifstream info("/proc/cpuinfo");
  for (std::string line; std::getline(info, line);) {
    if (line.starts_with("model name")) return line.substr(line.find(':') + 2);
  }
  return "unknown";
}

std::string compiler() {
#ifdef __clang__
  return __VERSION__;
#else
  return "GCC " __VERSION__;
#endif
}

nlohmann::ordered_json describe() {
  return {{"cpu", cpu_model()},
          {"compiler", compiler()},
          {"flags", EVERMAP_FLAGS},
          {"evermap", EVERMAP_VERSION},
          {"octomap", OctoMapBaseline::version()},
          {"threads", 1},
          {"clock", "CPU time of the process"},
          {"data", "simulated drive through the yard, 64 x 1024 beams, 200 m range"}};
}

void print(double leaf, std::size_t scans, const std::vector<Result>& results) {
  const double all_points = results[2].times.median;
  for (const Result& r : results) {
    fmt::print("{:4.1f} {:6} {:20} {:9.2f} {:9.2f} {:9.2f} {:10.1f} {:10.1f}\n", leaf, scans, r.name,
               r.times.median, r.times.low, r.times.high, all_points / r.times.median,
               static_cast<double>(r.memory_bytes) / 1e6);
  }
  std::fflush(stdout);  // the next leaf size may take minutes
}

nlohmann::ordered_json to_json(double leaf, std::size_t scans, const std::vector<Result>& results) {
  nlohmann::ordered_json json = {{"leaf_m", leaf}, {"scans", scans}, {"contenders", {}}};
  for (const Result& r : results) {
    json["contenders"].push_back(
        {{"name", r.name},
         {"median_ms", r.times.median},
         {"p10_ms", r.times.low},
         {"p90_ms", r.times.high},
         {"speedup_over_octomap_all_points", results[2].times.median / r.times.median},
         {"memory_bytes", r.memory_bytes}});
  }
  return json;
}

void run_all(const Options& options) {
  nlohmann::ordered_json report = describe();
  for (const auto& [key, value] : report.items()) fmt::print("{:9} {}\n", key, value.dump());
  fmt::print("\n{:>4} {:>6} {:20} {:>9} {:>9} {:>9} {:>10} {:>10}\n", "leaf", "scans", "", "median", "10 %",
             "90 %", "OctoMap/it", "map");
  fmt::print("{:>4} {:>6} {:20} {:>9} {:>9} {:>9} {:>10} {:>10}\n", "[m]", "", "", "[ms]", "[ms]", "[ms]", "",
             "[MB]");
  for (const double leaf : options.leaves) {
    const std::size_t scans = options.scans > 0 ? options.scans : default_scans(leaf);
    const std::vector<Result> results = run(leaf, scans);
    print(leaf, scans, results);
    report["leaves"].push_back(to_json(leaf, scans, results));
  }
  if (options.json.empty()) return;
  std::ofstream file(options.json);
  file << report.dump(2) << '\n';
  if (!file.flush()) throw std::runtime_error(options.json + ": cannot be written");
}

}  // namespace
}  // namespace evermap

int main(int argc, char** argv) {
  evermap::Options options;
  CLI::App app("Times evermap and OctoMap on the same scans, one thread, CPU time");
  app.add_option("--leaf", options.leaves, "Leaf edges")->type_name("METRES")->check(CLI::Range(0.05, 2.0));
  app.add_option("--scans", options.scans, "Scans of the drive; the first third is not counted")
      ->check(CLI::Range(3, 1000));
  app.add_option("--json", options.json, "Also write the figures to this file");
  CLI11_PARSE(app, argc, argv);

  const oneapi::tbb::global_control one_thread(oneapi::tbb::global_control::max_allowed_parallelism, 1);
  try {
    evermap::run_all(options);
  } catch (const std::exception& error) {
    fmt::print(stderr, "bench_versus_octomap: {}\n", error.what());
    return 1;
  }
}
