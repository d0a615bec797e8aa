// SPDX-FileCopyrightText: 2026 the evermap authors
// SPDX-License-Identifier: BSD-3-Clause
// How long each part of the work takes, on a drive through the quarry; the argument is the leaf edge in cm.
#include <bit>
#include <cstdint>
#include <filesystem>
#include <string>
#include <unistd.h>

#include <benchmark/benchmark.h>
#include <oneapi/tbb/global_control.h>

#include "drive.hpp"
#include <evermap/io/map_file.hpp>
#include <evermap/map/traversal.hpp>
#include <evermap/update/detail/encounter.hpp>
#include <evermap/update/detail/evidence.hpp>
#include <evermap/update/detail/impact.hpp>

namespace evermap {
namespace {

constexpr std::size_t kScans = 20;

/// Scans of the quarry, and a map that has seen them.
struct Setting {
  Drive drive;
  Octree octree;
};

Setting setting(const benchmark::State& state) {
  static const Drive drive = drive_through_quarry(kScans);
  return {drive, map_of(drive, static_cast<double>(state.range(0)) / 100)};
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

/// Every ray walked on its own, as a single query is.
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

std::vector<Encounter> meetings_of(const Octree& octree, const BundleGrid& bundles) {
  const UpdateParameters parameters;
  const RayFan fan(octree.grid(), bundles.origin_map, looked_at(bundles));
  return find_encounters(bundles, fan, octree.bricks_in(fan.voxels()), parameters);
}

/// Judging all that one scan's rays meet.
void impact(benchmark::State& state) {
  const Setting at = setting(state);
  const BundleGrid bundles = bundles_of(at).front();
  const UpdateParameters parameters;
  const std::vector<Encounter> encounters = meetings_of(at.octree, bundles);
  const AlignmentError error = alignment_error(at.octree, bundles);
  for (auto _ : state) {
    double sum = 0;
    for (const Encounter& met : encounters) {
      const Ray ray{bundles.origin_map, met.target.end_map};
      const Gaussian leaf = at.octree.gaussian(met.key, *met.leaf);
      JudgedLeaf judged(leaf, at.octree.grid().edge, error.at((leaf.mean - ray.origin).norm()), parameters);
      sum += judged.impact(ray, bundles.bundles()[met.bundle].points.covariance, met.target.until);
    }
    benchmark::DoNotOptimize(sum);
  }
  state.counters["encounters"] = static_cast<double>(encounters.size());
}

void apply(benchmark::State& state) {
  Setting at = setting(state);
  const BundleGrid bundles = bundles_of(at).front();
  const UpdateParameters parameters;
  const Evidence evidence = trace(at.octree, bundles, parameters);
  // Evidence names leaves that the first time may delete: afterwards, bundles alone are applied.
  apply(at.octree, bundles, evidence, parameters, 1);
  for (auto _ : state) apply(at.octree, bundles, {}, parameters, 1);
}

void update(benchmark::State& state, const UpdateParameters& parameters) {
  Setting at = setting(state);
  std::size_t i = 0;
  for (auto _ : state) {
    update(at.octree, condense(at.drive.scans[i], at.drive.T_map_sensor[i], at.octree.grid(), {}),
           parameters);
    i = (i + 1) % kScans;
  }
}

/// A view of the map, as a reader takes it between two scans.
void snapshot(benchmark::State& state) {
  const Setting at = setting(state);
  for (auto _ : state) {
    const Octree view = at.octree;
    benchmark::DoNotOptimize(&view);
  }
}

/// An update after which somebody always holds a view of the map as it was: each brick that changes is
/// copied.
void update_beside_a_view(benchmark::State& state) {
  Setting at = setting(state);
  std::size_t i = 0;
  for (auto _ : state) {
    const Octree view = at.octree;
    update(at.octree, condense(at.drive.scans[i], at.drive.T_map_sensor[i], at.octree.grid(), {}),
           UpdateParameters{});
    i = (i + 1) % kScans;
  }
}

/// What no implementation can do without, if it were told for free which ray meets which leaf: every point is
/// read, put into its voxel and looked up once, and every leaf that a ray meets and the scan did not hit is
/// judged once.
void floor(benchmark::State& state) {
  const Setting at = setting(state);
  const std::vector<BundleGrid> scans = bundles_of(at);
  std::vector<std::vector<Encounter>> encounters;
  for (const BundleGrid& bundles : scans) encounters.push_back(meetings_of(at.octree, bundles));
  std::vector<std::uint64_t> table;
  std::size_t i = 0;
  double sum = 0;
  for (auto _ : state) {
    const Scan& scan = at.drive.scans[i];
    table.assign(std::bit_ceil(2 * scan.p_sensor.size()), 0);
    for (const Eigen::Vector3d& p_sensor : scan.p_sensor) {
      const std::uint64_t key = at.octree.grid().key(at.drive.T_map_sensor[i] * p_sensor)->bits();
      std::size_t slot = hash_bits(key) & (table.size() - 1);
      while (table[slot] != 0 && table[slot] != key) slot = (slot + 1) & (table.size() - 1);
      table[slot] = key;
    }
    for (const Encounter& met : encounters[i]) {
      const Ray ray{scans[i].origin_map, met.target.end_map};
      sum += closest_approach(ray, at.octree.gaussian(met.key, *met.leaf)).mahalanobis_squared;
    }
    i = (i + 1) % kScans;
  }
  benchmark::DoNotOptimize(sum);
}

/// A map file that lives as long as the benchmark.
struct MapFile {
  std::filesystem::path path =
      std::filesystem::temp_directory_path() / ("evermap_parts_" + std::to_string(getpid()) + ".evm");
  ~MapFile() { std::filesystem::remove(path); }
};

/// A hilly surface of ten million leaves.
const Octree& large_map() {
  static const Octree map = [] {
    constexpr int kWide = 3163;
    constexpr double kEdge = 0.1;  // [m]
    Octree octree(VoxelGrid{.edge = kEdge});
    for (int x = 0; x < kWide; ++x) {
      Scan row;
      for (int y = 0; y < kWide; ++y) {
        row.p_sensor.emplace_back(kEdge * (x + 0.5), kEdge * (y + 0.5),
                                  2 * std::sin(0.01 * x) + std::cos(0.02 * y));
      }
      add_cloud(octree, row, Pose{}, {}, UpdateParameters{});
    }
    return octree;
  }();
  return map;
}

void save(benchmark::State& state) {
  const MapFile file;
  const Octree& map = large_map();
  for (auto _ : state) save_map(file.path, map);
  state.counters["leaves"] = static_cast<double>(map.leaf_count());
  state.counters["bytes"] = static_cast<double>(std::filesystem::file_size(file.path));
}

void load(benchmark::State& state) {
  const MapFile file;
  save_map(file.path, large_map());
  for (auto _ : state) benchmark::DoNotOptimize(load_map(file.path));
}

void leaf_edges(benchmark::internal::Benchmark* benchmark) {
  benchmark->ArgName("cm")
      ->Arg(10)
      ->Arg(20)
      ->Arg(40)
      ->Arg(100)
      ->Unit(benchmark::kMillisecond)
      ->MeasureProcessCPUTime();
}

BENCHMARK(condense)->Apply(leaf_edges);
BENCHMARK(traverse)->Apply(leaf_edges);
BENCHMARK_CAPTURE(trace, default, UpdateParameters{})->Apply(leaf_edges);
BENCHMARK_CAPTURE(trace, paper, UpdateParameters::paper())->Apply(leaf_edges);
BENCHMARK(impact)->Apply(leaf_edges);
BENCHMARK(apply)->Apply(leaf_edges);
BENCHMARK_CAPTURE(update, default, UpdateParameters{})->Apply(leaf_edges);
BENCHMARK_CAPTURE(update, paper, UpdateParameters::paper())->Apply(leaf_edges);
BENCHMARK(snapshot)->Apply(leaf_edges);
BENCHMARK(update_beside_a_view)->Apply(leaf_edges);
BENCHMARK(floor)->Apply(leaf_edges);
BENCHMARK(save)->Unit(benchmark::kMillisecond)->MeasureProcessCPUTime();
BENCHMARK(load)->Unit(benchmark::kMillisecond)->MeasureProcessCPUTime();

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
