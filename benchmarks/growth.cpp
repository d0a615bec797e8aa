// SPDX-FileCopyrightText: 2026 the evermap authors
// SPDX-License-Identifier: BSD-3-Clause
// Where the time of a scan goes, and how it grows with the leaf's size, the range, the rays, the map and
// falls with threads: on a drive through the quarry, for plots. What is compared takes turns scan by
// scan, so that whatever else the machine does meets all alike.
#include <algorithm>
#include <chrono>
#include <cstdio>
#include <filesystem>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include <CLI/CLI.hpp>
#include <fmt/core.h>
#include <oneapi/tbb/global_control.h>
#include <oneapi/tbb/task_arena.h>

#include "cpu_time.hpp"
#include "drive.hpp"
#include "experiments/result_file.hpp"
#include <evermap/update/detail/encounter.hpp>
#include <evermap/update/detail/evidence.hpp>

namespace evermap {
namespace {

constexpr double kEdge = 0.2;  ///< [m] where it is not the leaf's size that is varied

double wall_seconds() {
  return std::chrono::duration<double>(std::chrono::steady_clock::now().time_since_epoch()).count();
}

double median(std::vector<double> values) {
  const auto middle = values.begin() + static_cast<std::ptrdiff_t>(values.size() / 2);
  std::nth_element(values.begin(), middle, values.end());
  return *middle;
}

/// One way to take the scans of a drive.
struct Variant {
  double x;  ///< its place on the axis
  Octree map;
  std::vector<Scan> scans;
  Parameters parameters{};
  int threads = 1;
};

/// Medians of a scan.
struct Cost {
  double cpu_ms, wall_ms;
  double bundles;
};

std::vector<Cost> take_turns(std::vector<Variant> variants, const std::vector<Pose>& T_map_sensor) {
  std::vector<std::vector<double>> cpu(variants.size()), wall(variants.size()), bundles(variants.size());
  for (std::size_t scan = 0; scan < T_map_sensor.size(); ++scan) {
    for (std::size_t i = 0; i < variants.size(); ++i) {
      Variant& variant = variants[i];
      oneapi::tbb::task_arena arena(variant.threads);
      const double cpu_begin = cpu_seconds();
      const double wall_begin = wall_seconds();
      const std::size_t condensed = arena.execute([&] {
        const BundleGrid grid =
            condense(variant.scans[scan], T_map_sensor[scan], variant.map.grid(), variant.parameters.lidar);
        update(variant.map, grid, variant.parameters.update);
        return grid.bundles().size();
      });
      wall[i].push_back(1e3 * (wall_seconds() - wall_begin));
      cpu[i].push_back(1e3 * (cpu_seconds() - cpu_begin));
      bundles[i].push_back(static_cast<double>(condensed));
    }
  }
  std::vector<Cost> costs;
  for (std::size_t i = 0; i < variants.size(); ++i)
    costs.push_back({median(cpu[i]), median(wall[i]), median(bundles[i])});
  return costs;
}

/// Points of a line.
Json line(const std::vector<double>& x, const std::vector<Cost>& costs, double Cost::*value) {
  Json points = Json::array();
  for (std::size_t i = 0; i < x.size(); ++i) points.push_back({x[i], costs[i].*value});
  return points;
}

/// What experiments/report.py draws as one plot.
Json panel(const std::string& title, const std::string& x, Json series, bool log_x = false) {
  return {{"title", title},    {"x", x},         {"y", "median of a scan [ms]"},
          {"from_zero", true}, {"log_x", log_x}, {"series", std::move(series)}};
}

void print(const std::string& what, const std::vector<Variant>& variants, const std::vector<Cost>& costs) {
  fmt::print("\n{:>16} {:>8} {:>9} {:>10} {:>10}\n", what, "threads", "bundles", "CPU [ms]", "wall [ms]");
  for (std::size_t i = 0; i < costs.size(); ++i) {
    fmt::print("{:>16} {:>8} {:>9.0f} {:>10.2f} {:>10.2f}\n", variants[i].x, variants[i].threads,
               costs[i].bundles, costs[i].cpu_ms, costs[i].wall_ms);
  }
  std::fflush(stdout);
}

std::vector<Cost> measure(const std::string& what, const std::vector<Variant>& variants, const Drive& drive) {
  const std::vector<Cost> costs = take_turns(variants, drive.T_map_sensor);
  print(what, variants, costs);
  return costs;
}

std::vector<double> places(const std::vector<Variant>& variants) {
  std::vector<double> x;
  for (const Variant& variant : variants) x.push_back(variant.x);
  return x;
}

Json over_leaf_and_threads(const Drive& drive) {
  const std::vector<double> edges{1.0, 0.8, 0.6, 0.4, 0.2, 0.1};  // [m]
  std::vector<Cost> one, two;
  for (const double edge : edges) {
    Variant alone{edge, map_of(drive, edge), drive.scans};
    Variant both = alone;
    both.threads = 2;
    const std::vector<Cost> costs = measure("leaf [m]", {alone, both}, drive);
    one.push_back(costs[0]);
    two.push_back(costs[1]);
  }
  return panel(
      "Leaf size and threads", "leaf edge [m]",
      {{"one thread", line(edges, one, &Cost::wall_ms)}, {"two threads", line(edges, two, &Cost::wall_ms)}},
      /*log_x=*/true);
}

Json over_range(const Drive& drive) {
  const Octree map = map_of(drive, kEdge);
  std::vector<Variant> variants;
  for (const double range : {25.0, 50.0, 100.0, 200.0}) {
    variants.push_back({range, map, drive.scans});
    variants.back().parameters.lidar.max_range = range;
  }
  const std::vector<Cost> costs = measure("range [m]", variants, drive);
  return panel("Range limit", "range [m]", {{"one thread", line(places(variants), costs, &Cost::cpu_ms)}});
}

/// Every n-th point of each scan.
std::vector<Scan> thinned(const std::vector<Scan>& scans, std::size_t n) {
  std::vector<Scan> thin(scans.size());
  for (std::size_t i = 0; i < scans.size(); ++i) {
    for (std::size_t k = 0; k < scans[i].p_sensor.size(); k += n)
      thin[i].p_sensor.push_back(scans[i].p_sensor[k]);
  }
  return thin;
}

Json over_rays(const Drive& drive) {
  const Octree map = map_of(drive, kEdge);
  std::vector<Variant> variants;
  for (const std::size_t n : {8U, 4U, 2U, 1U}) {
    variants.push_back(
        {static_cast<double>(drive.scans[0].p_sensor.size() / n), map, thinned(drive.scans, n)});
  }
  const std::vector<Cost> costs = measure("points", variants, drive);
  std::vector<double> bundles;
  for (const Cost& cost : costs) bundles.push_back(cost.bundles);
  return panel("Rays", "bundles a scan", {{"one thread", line(bundles, costs, &Cost::cpu_ms)}});
}

/// The map and `copies` - 1 more of it, side by side.
Octree repeated(const Octree& map, int copies) {
  constexpr double kDistance = 1000;  // [m] no ray reaches a copy
  const int shift = static_cast<int>(kDistance / map.grid().edge);
  Octree large(map.grid());
  for (int copy = 0; copy < copies; ++copy) {
    map.for_each_leaf([&](VoxelKey key, const Leaf& leaf) {
      const Eigen::Vector3i voxel = key.voxel() + Eigen::Vector3i(copy * shift, 0, 0);
      large.find_or_insert(VoxelKey::from_voxel(voxel)) = leaf;
    });
  }
  return large;
}

Json over_map_size(const Drive& drive) {
  const Octree map = map_of(drive, kEdge);
  std::vector<Variant> variants;
  for (const int copies : {1, 2, 5, 10})
    variants.push_back({static_cast<double>(copies), repeated(map, copies), drive.scans});
  const std::vector<Cost> costs = measure("map's area", variants, drive);
  return panel("Map size", "area, relative", {{"one thread", line(places(variants), costs, &Cost::cpu_ms)}});
}

/// What an update is made of, each part done by itself.
struct Stages {
  double condense, align, sort, meet, judge, apply;  ///< [ms] CPU time
};

template <class Work>
double cpu_milliseconds(const Work& work) {
  const double begin = cpu_seconds();
  work();
  return 1e3 * (cpu_seconds() - begin);
}

Stages stages_of(Octree& map, const Scan& scan, const Pose& T_map_sensor) {
  const UpdateParameters parameters;
  Stages stages{};
  BundleGrid bundles;
  stages.condense = cpu_milliseconds([&] { bundles = condense(scan, T_map_sensor, map.grid(), {}); });
  stages.align = cpu_milliseconds([&] { alignment_error(map, bundles); });
  std::optional<RayFan> fan;
  stages.sort = cpu_milliseconds([&] { fan.emplace(map.grid(), bundles.origin_map, looked_at(bundles)); });
  stages.meet =
      cpu_milliseconds([&] { find_encounters(bundles, *fan, map.bricks_in(fan->voxels()), parameters); });
  Evidence evidence;
  const double trace_all = cpu_milliseconds([&] { evidence = trace(map, bundles, parameters); });
  stages.judge = std::max(0.0, trace_all - stages.align - stages.sort - stages.meet);
  stages.apply = cpu_milliseconds([&] { apply(map, bundles, evidence, parameters, 1); });
  return stages;
}

/// Where the time goes: bars of each stage for some leaf sizes.
Json profile(const Drive& drive) {
  const std::vector<std::pair<const char*, double Stages::*>> parts{
      {"condense", &Stages::condense}, {"alignment error", &Stages::align}, {"sort rays", &Stages::sort},
      {"meet leaves", &Stages::meet},  {"judge", &Stages::judge},           {"apply", &Stages::apply}};
  Json plot = panel("Where the time goes", "", Json::object());
  for (const auto& part : parts) plot["groups"].push_back(part.first);
  fmt::print("\n{:>8}", "leaf [m]");
  for (const auto& part : parts) fmt::print(" {:>16}", part.first);
  fmt::print("\n");
  for (const double edge : {1.0, 0.4, 0.2, 0.1}) {
    Octree map = map_of(drive, edge);
    std::vector<Stages> all;
    for (std::size_t i = 0; i < drive.scans.size(); ++i)
      all.push_back(stages_of(map, drive.scans[i], drive.T_map_sensor[i]));
    Json& series = plot["series"][fmt::format("leaf {} m", edge)];
    fmt::print("{:>8}", edge);
    for (const auto& part : parts) {
      std::vector<double> milliseconds;
      for (const Stages& stages : all) milliseconds.push_back(stages.*part.second);
      series.push_back(median(milliseconds));
      fmt::print(" {:>16.2f}", series.back().get<double>());
    }
    fmt::print("\n");
  }
  return plot;
}

void run(std::size_t scans, const std::filesystem::path& folder) {
  std::filesystem::create_directories(folder);
  const Drive drive = drive_through_quarry(scans);
  Json figures;
  {
    const oneapi::tbb::global_control one_thread(oneapi::tbb::global_control::max_allowed_parallelism, 1);
    figures["profile"] = Json::array({profile(drive)});
    figures["growth"] = Json::array({over_range(drive), over_rays(drive), over_map_size(drive)});
  }
  figures["threads"] = Json::array({over_leaf_and_threads(drive)});
  write_file(folder / "growth.json", dump({{"figures", figures}}));
}

}  // namespace
}  // namespace evermap

int main(int argc, char** argv) {
  std::size_t scans = 40;
  std::string folder = "growth";
  CLI::App app("Where the time of a scan goes, and how it grows");
  app.add_option("--scans", scans, "Scans of the drive")->check(CLI::Range(2, 600))->capture_default_str();
  app.add_option("-o,--output", folder, "Folder for the figures to plot")->capture_default_str();
  CLI11_PARSE(app, argc, argv);
  try {
    evermap::run(scans, folder);
  } catch (const std::exception& error) {
    fmt::print(stderr, "bench_growth: {}\n", error.what());
    return 1;
  }
}
