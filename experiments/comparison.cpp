// SPDX-FileCopyrightText: 2026 the evermap authors
// SPDX-License-Identifier: BSD-3-Clause
#include "experiments/comparison.hpp"

#include <algorithm>
#include <utility>

#include <oneapi/tbb/parallel_for.h>

#include "experiments/closed_loop.hpp"
#include "experiments/metrics.hpp"
#include <evermap/simulation/noise.hpp>

namespace evermap {
namespace {

Pose with_noise(const Pose& T_map_sensor, const PoseNoise& noise, std::size_t scan) {
  Twist twist;
  for (Eigen::Index axis = 0; axis < 6; ++axis) {
    const double sigma = axis < 3 ? noise.translation : noise.rotation;
    twist[axis] = sigma * standard_normal(noise.seed, 6 * scan + static_cast<std::uint64_t>(axis));
  }
  return T_map_sensor * exp(twist);
}

/// The scans after which is measured.
std::vector<std::size_t> measured_scans(std::size_t scans, std::size_t measurements) {
  std::vector<std::size_t> measured;
  const std::size_t count = std::min(scans, measurements);
  for (std::size_t i = 1; i <= count; ++i) measured.push_back(i * scans / count - 1);
  return measured;
}

/// The comparison as it goes on.
class Comparison {
 public:
  Comparison(const Dataset& dataset, Mappers mappers, const ComparisonRules& rules)
      : dataset_(dataset), rules_(rules), mappers_(std::move(mappers)), results_(mappers_.size()) {
    const Points survey = dataset_.survey();
    for_each_mapper([&](std::size_t i) {
      mappers_[i]->start(survey, dataset_.scans().front().T_map_sensor);
      results_[i] = {
          {"name", mappers_[i]->name()}, {"version", mappers_[i]->version()}, {"rows", Json::array()}};
    });
    if (!rules_.finds_poses) return;
    for (const auto& mapper : mappers_) {
      loops_.emplace_back(*mapper, rules_.leaf, dataset_.scans().front().T_map_sensor, dataset_.lidar);
    }
  }

  void update(std::size_t scan) {
    const AlignedScan& aligned = dataset_.scans()[scan];
    const Pose T_map_sensor = with_noise(aligned.T_map_sensor, rules_.noise, scan);
    for_each_mapper([&](std::size_t i) {
      if (rules_.finds_poses) {
        const auto T_odom_sensor = rules_.noise.is_there() ? std::optional(T_map_sensor) : std::nullopt;
        loops_[i].process(aligned.scan, dataset_.time(scan), T_odom_sensor, aligned.T_map_sensor);
      } else {
        mappers_[i]->update(aligned.scan, T_map_sensor);
      }
      for (const DynamicObject& object : dataset_.dynamic_objects()) {
        const Points& p_map = object.p_map[scan];
        results_[i]["shown"][object.name].push_back(fraction_seen(*mappers_[i], &Mapper::claims, p_map));
        results_[i]["noticed"][object.name].push_back(fraction_seen(*mappers_[i], &Mapper::notices, p_map));
      }
    });
  }

  void measure(std::size_t scan) {
    const Truth truth = dataset_.truth(scan);
    for_each_mapper([&](std::size_t i) {
      Json row = measure_surface(mappers_[i]->surface(), truth, dataset_.area, rules_.leaf);
      row["scan"] = dataset_.number(scan);
      results_[i]["rows"].push_back(std::move(row));
    });
  }

  Json finish() {
    const std::size_t last = dataset_.scans().size() - 1;
    const Truth truth = dataset_.truth(last);
    const Changes changes = dataset_.changes(rules_.leaf);
    for_each_mapper([&](std::size_t i) {
      const Mapper& mapper = *mappers_[i];
      const Points map = mapper.surface();
      Json& end = results_[i]["end"];
      end = measure_changes(mapper, changes, dataset_.position_sigma);
      end.update(measure_uncropped(map, truth, dataset_.area));
      end["memory_bytes"] = mapper.memory_bytes();
      if (rules_.finds_poses) end.update(loops_[i].errors());
      if (rules_.at_end) end.update(rules_.at_end(mapper, map, truth));
      if (rules_.has_view) results_[i]["view"] = seen_from_above(map, truth, dataset_.view, rules_.leaf);
    });
    Json numbers = Json::array();
    for (std::size_t scan = 0; scan <= last; ++scan) numbers.push_back(dataset_.number(scan));
    return {{"scans", dataset_.scans().size()},
            {"scan_numbers", numbers},
            {"unchanged_points", changes.unchanged.size()},
            {"removed_points", changes.removed.size()},
            {"observed_points", truth.observed.size()},
            {"position_sigma_m", dataset_.position_sigma},
            {"view_cell_m", kCellEdge},
            {"mappers", results_}};
  }

 private:
  void for_each_mapper(const std::function<void(std::size_t)>& task) const {
    oneapi::tbb::parallel_for(std::size_t{0}, mappers_.size(), task);
  }

  /// Fraction of an object's points in a scan that the map claims or notices after it; null when there are
  /// none.
  Json fraction_seen(const Mapper& mapper, bool (Mapper::*says)(const Eigen::Vector3d&, double) const,
                     const Points& p_map) const {
    if (p_map.empty()) return nullptr;
    return fraction_true(
        p_map, [&](const Eigen::Vector3d& p) { return (mapper.*says)(p, dataset_.position_sigma); });
  }

  const Dataset& dataset_;
  const ComparisonRules& rules_;
  Mappers mappers_;
  std::vector<ClosedLoop> loops_;  ///< when poses are to be found
  std::vector<Json> results_;
};

}  // namespace

Json compare_mappers(const Dataset& dataset, Mappers mappers, const ComparisonRules& rules,
                     const Progress& progress) {
  std::erase(mappers, nullptr);
  Comparison comparison(dataset, std::move(mappers), rules);
  const std::size_t scans = dataset.scans().size();
  const std::vector<std::size_t> measured = measured_scans(scans, rules.measurements);
  for (std::size_t scan = 0; scan < scans; ++scan) {
    comparison.update(scan);
    if (std::binary_search(measured.begin(), measured.end(), scan)) comparison.measure(scan);
    progress(scan + 1, scans);
  }
  return comparison.finish();
}

Mappers mappers_named(const std::vector<std::string>& names, double leaf, const LidarParameters& lidar) {
  Mappers mappers;
  mappers.reserve(names.size());
  for (const std::string& name : names) mappers.push_back(make_mapper(name, leaf, lidar));
  return mappers;
}

Mappers usual_mappers(double leaf, const LidarParameters& lidar) {
  std::vector<std::string> names = mapper_names();
  std::erase(names, "OctoMap, voxel means");
  return mappers_named(names, leaf, lidar);
}

Json at_end(const Json& result_of_mapper, const std::string& metric) {
  const Json& end = result_of_mapper["end"];
  return end.contains(metric) ? end[metric] : result_of_mapper["rows"].back().value(metric, Json());
}

}  // namespace evermap
