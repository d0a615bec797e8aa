// SPDX-FileCopyrightText: 2026 the evermap authors
// SPDX-License-Identifier: BSD-3-Clause
// How long it takes to register a scan of the quarry to its map, and how well it is done, beside PCL's NDT
// and GICP where PCL was found; the argument is the leaf edge in cm. Starts are up to 0.3 m and 2 degrees
// off. One thread. Making the target (our map is at hand; theirs must be made from its points) is not
// counted.
#include <cmath>
#include <random>

#include <benchmark/benchmark.h>
#include <oneapi/tbb/global_control.h>

#include <evermap/geometry/detail/degree.hpp>
#include <evermap/localization/detail/perturbation.hpp>
#include <evermap/localization/detail/registration.hpp>
#include <evermap/simulation/scenario_drive.hpp>
#include <evermap/update/detail/map_updater.hpp>

#ifdef EVERMAP_HAS_PCL
#include <pcl/console/print.h>
#include <pcl/registration/gicp.h>
#include <pcl/registration/ndt.h>

#include "experiments/pcl_cloud.hpp"
#endif

namespace evermap {
namespace {

constexpr std::size_t kScans = 20;

struct Setting {
  std::vector<Eigen::Vector3d> survey;
  std::vector<Scan> scans;
  std::vector<Pose> truth;
  std::vector<Pose> starts;

  Setting() {
    const ScenarioDrive drive(shipped_scenario("quarry"));
    survey = drive.survey(0.1);
    std::mt19937_64 generator(1);
    std::normal_distribution<double> normal;
    std::uniform_real_distribution<double> unit(0, 1);
    const auto direction = [&] {
      return Eigen::Vector3d(normal(generator), normal(generator), normal(generator)).normalized();
    };
    for (std::size_t i = 0; i < kScans; ++i) {
      scans.push_back(drive.scan(5 * i).scan);
      truth.push_back(drive.T_map_sensor(5 * i));
      Twist off;
      off << 0.3 * std::cbrt(unit(generator)) * direction(), 2 * kDegree * unit(generator) * direction();
      starts.push_back(perturb(truth.back(), off));
    }
  }
};
const Setting& setting() {
  static const Setting the_setting;
  return the_setting;
}

double edge_of(const benchmark::State& state) { return static_cast<double>(state.range(0)) / 100; }

/// Registers one scan after the other by `align(scan index)`, a pose, and counts how far off it ends.
template <class Align>
void run(benchmark::State& state, const Align& align) {
  std::vector<Pose> found(kScans);
  std::size_t i = 0;
  for (auto _ : state) {
    found[i % kScans] = align(i % kScans);
    ++i;
  }
  const std::size_t seen = std::min(i, kScans);
  double translation = 0;
  double rotation = 0;
  for (std::size_t k = 0; k < seen; ++k) {
    const Twist off = difference(setting().truth[k], found[k]);
    translation += off.head<3>().squaredNorm();
    rotation += off.tail<3>().squaredNorm();
  }
  state.counters["rmse_mm"] = 1e3 * std::sqrt(translation / static_cast<double>(seen));
  state.counters["rmse_mdeg"] = 1e3 * std::sqrt(rotation / static_cast<double>(seen)) / kDegree;
}

Octree map_of_survey(double edge) {
  Octree map(VoxelGrid{.edge = edge});
  Scan cloud;
  cloud.p_sensor = setting().survey;
  add_cloud(map, cloud, Pose{}, {}, UpdateParameters{});
  return map;
}

void evermap_registration(benchmark::State& state) {
  const Octree map = map_of_survey(edge_of(state));
  run(state, [&](std::size_t i) {
    const auto bundles = bundles_in_sensor_frame(setting().scans[i], map.grid().edge, {});
    return register_bundles(map, bundles, {setting().starts[i]}, {}).T_map_sensor;
  });
}

void evermap_coarse_to_fine(benchmark::State& state) {
  const Octree map = map_of_survey(edge_of(state));
  run(state, [&](std::size_t i) {
    return register_coarse_to_fine(map, setting().scans[i], {setting().starts[i]}, {}, {}).T_map_sensor;
  });
}

#ifdef EVERMAP_HAS_PCL
/// Thins the scan to one point per leaf, as is usual, and aligns it.
Pose align(pcl::Registration<pcl::PointXYZ, pcl::PointXYZ>& method, std::size_t i, double edge) {
  const PclCloud::Ptr scan = pcl_cloud_of(setting().scans[i].p_sensor, edge);
  const Eigen::Matrix4d end = pcl_align(method, scan, setting().starts[i]);
  return {nearest_rotation(end.topLeftCorner<3, 3>()), end.topRightCorner<3, 1>()};
}

void pcl_ndt(benchmark::State& state) {
  pcl::NormalDistributionsTransform<pcl::PointXYZ, pcl::PointXYZ> ndt;
  ndt.setResolution(1.0F);             // PCL's default: its cells need many points each
  ndt.setTransformationEpsilon(1e-8);  // of the squared step; the default stops at the first one
  ndt.setMaximumIterations(100);
  ndt.setInputTarget(pcl_cloud_of(setting().survey, 0));
  run(state, [&](std::size_t i) { return align(ndt, i, edge_of(state)); });
}

void pcl_gicp(benchmark::State& state) {
  pcl::GeneralizedIterativeClosestPoint<pcl::PointXYZ, pcl::PointXYZ> gicp;
  gicp.setMaxCorrespondenceDistance(1.0);
  gicp.setTransformationEpsilon(1e-5);
  gicp.setRotationEpsilon(1e-5);
  gicp.setInputTarget(pcl_cloud_of(setting().survey, edge_of(state)));
  align(gicp, 0, edge_of(state));  // computes the target's covariances, which are then kept
  run(state, [&](std::size_t i) { return align(gicp, i, edge_of(state)); });
}
#endif

void leaf_edges(benchmark::internal::Benchmark* benchmark) {
  benchmark->ArgName("cm")->Arg(20)->Arg(40)->Unit(benchmark::kMillisecond)->MeasureProcessCPUTime();
  benchmark->Iterations(kScans);
}

BENCHMARK(evermap_registration)->Apply(leaf_edges);
BENCHMARK(evermap_coarse_to_fine)->Apply(leaf_edges);
#ifdef EVERMAP_HAS_PCL
BENCHMARK(pcl_ndt)->Apply(leaf_edges);
BENCHMARK(pcl_gicp)->Apply(leaf_edges);
#endif

}  // namespace
}  // namespace evermap

int main(int argc, char** argv) {
  const oneapi::tbb::global_control one_thread(oneapi::tbb::global_control::max_allowed_parallelism, 1);
#ifdef EVERMAP_HAS_PCL
  pcl::console::setVerbosityLevel(pcl::console::L_ALWAYS);
#endif
  benchmark::Initialize(&argc, argv);
  if (benchmark::ReportUnrecognizedArguments(argc, argv)) return 2;
  benchmark::RunSpecifiedBenchmarks();
  return 0;
}
