// SPDX-FileCopyrightText: 2026 the evermap authors
// SPDX-License-Identifier: BSD-3-Clause
// How long each part of the work takes, on a drive through the yard; the argument is the leaf edge in cm.
#include <filesystem>
#include <string>
#include <unistd.h>

#include <benchmark/benchmark.h>
#include <oneapi/tbb/global_control.h>

#include "drive.hpp"
#include <evermap/io/map_file.hpp>
#include <evermap/map/traversal.hpp>
#include <evermap/update/evidence.hpp>

namespace evermap {
namespace {

constexpr std::size_t kScans = 20;

/// A map of the yard as it was, and scans of it as it is now.
struct Setting {
  Drive drive;
  Octree octree;
};

double edge_of(const benchmark::State& state) { return static_cast<double>(state.range(0)) / 100; }

Setting setting(const benchmark::State& state) {
  const Yard yard = make_yard();
  return {drive_through(yard, yard.now, kScans), map_of(survey_of(yard.before), edge_of(state))};
}

void condense(benchmark::State& state) {
  const Setting at = setting(state);
  std::size_t i = 0;
  for (auto _ : state) {
    benchmark::DoNotOptimize(condense(at.drive.scans[i], at.drive.T_map_sensor[i], at.octree.grid(), {}));
    i = (i + 1) % kScans;
  }
}

std::vector<BundleGrid> bundles_of(const Setting& at) {
  std::vector<BundleGrid> bundles;
  for (std::size_t i = 0; i < kScans; ++i) {
    bundles.push_back(condense(at.drive.scans[i], at.drive.T_map_sensor[i], at.octree.grid(), {}));
  }
  return bundles;
}

void traverse(benchmark::State& state) {
  const Setting at = setting(state);
  const std::vector<BundleGrid> scans = bundles_of(at);
  std::size_t rays = 0;
  std::size_t leaves = 0;
  for (auto _ : state) {
    const BundleGrid& bundles = scans[static_cast<std::size_t>(state.iterations()) % kScans];
    for (const RayBundle& bundle : bundles.bundles()) {
      traverse(at.octree, Ray{bundles.origin_map, bundle.points.mean},
               [&](VoxelKey, const Leaf&, double, double) { ++leaves; });
    }
    rays += bundles.bundles().size();
  }
  benchmark::DoNotOptimize(leaves);
  state.counters["rays"] = benchmark::Counter(static_cast<double>(rays), benchmark::Counter::kIsRate);
}

void trace(benchmark::State& state, const UpdateParameters& parameters) {
  const Setting at = setting(state);
  const std::vector<BundleGrid> scans = bundles_of(at);
  std::size_t i = 0;
  for (auto _ : state) {
    benchmark::DoNotOptimize(trace(at.octree, scans[i], parameters));
    i = (i + 1) % kScans;
  }
}

void update(benchmark::State& state, const UpdateParameters& parameters) {
  Setting at = setting(state);
  std::size_t i = 0;
  for (auto _ : state) {
    update(at.octree, at.drive.scans[i], at.drive.T_map_sensor[i], parameters);
    i = (i + 1) % kScans;
  }
}

/// A map file that lives as long as the benchmark.
struct MapFile {
  std::filesystem::path path =
      std::filesystem::temp_directory_path() / ("evermap_parts_" + std::to_string(getpid()) + ".evm");
  ~MapFile() { std::filesystem::remove(path); }
};

void save(benchmark::State& state) {
  const Setting at = setting(state);
  const MapFile file;
  for (auto _ : state) save_map(file.path, at.octree);
  state.counters["bytes"] = static_cast<double>(std::filesystem::file_size(file.path));
}

void load(benchmark::State& state) {
  const Setting at = setting(state);
  const MapFile file;
  save_map(file.path, at.octree);
  for (auto _ : state) benchmark::DoNotOptimize(load_map(file.path));
}

void leaf_edges(benchmark::internal::Benchmark* benchmark) {
  benchmark->ArgName("cm")->Arg(10)->Arg(20)->Arg(40)->Unit(benchmark::kMillisecond)->MeasureProcessCPUTime();
}

BENCHMARK(condense)->Apply(leaf_edges);
BENCHMARK(traverse)->Apply(leaf_edges);
BENCHMARK_CAPTURE(trace, default, UpdateParameters{})->Apply(leaf_edges);
BENCHMARK_CAPTURE(trace, paper, UpdateParameters::paper())->Apply(leaf_edges);
BENCHMARK_CAPTURE(update, default, UpdateParameters{})->Apply(leaf_edges);
BENCHMARK_CAPTURE(update, paper, UpdateParameters::paper())->Apply(leaf_edges);
BENCHMARK(save)->Apply(leaf_edges);
BENCHMARK(load)->Apply(leaf_edges);

}  // namespace
}  // namespace evermap

int main(int argc, char** argv) {
  // One thread, so that figures compare between machines and with programs that know only one.
  const oneapi::tbb::global_control one_thread(oneapi::tbb::global_control::max_allowed_parallelism, 1);
  benchmark::Initialize(&argc, argv);
  if (benchmark::ReportUnrecognizedArguments(argc, argv)) return 2;
  benchmark::RunSpecifiedBenchmarks();
  return 0;
}
