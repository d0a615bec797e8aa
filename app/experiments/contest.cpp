// SPDX-FileCopyrightText: 2026 the evermap authors
// SPDX-License-Identifier: BSD-3-Clause
#include "experiments/contest.hpp"

#include <algorithm>
#include <limits>
#include <utility>

#include <oneapi/tbb/parallel_for.h>

#include "experiments/measures.hpp"
#include "experiments/pilot.hpp"
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

template <class Task>
void side_by_side(std::size_t count, const Task& task) {
  oneapi::tbb::parallel_for(std::size_t{0}, count, [&](std::size_t i) { task(i); });
}

/// The contest as it goes on.
class Contest {
 public:
  Contest(const Course& course, std::vector<std::unique_ptr<Contender>> contenders, const ContestRules& rules)
      : course_(course), rules_(rules), contenders_(std::move(contenders)), results_(contenders_.size()) {
    const Points survey = course.survey();
    side_by_side(contenders_.size(), [&](std::size_t i) {
      contenders_[i]->start(survey);
      results_[i] = {
          {"name", contenders_[i]->name()}, {"version", contenders_[i]->version()}, {"rows", Json::array()}};
    });
    if (!rules_.finds_poses) return;
    for (const auto& contender : contenders_) {
      pilots_.emplace_back(*contender, rules_.leaf, course_.scans().front().T_map_sensor, course_.lidar);
    }
  }

  void take(std::size_t scan) {
    const AlignedScan& aligned = course_.scans()[scan];
    const Pose T_map_sensor = with_noise(aligned.T_map_sensor, rules_.noise, scan);
    side_by_side(contenders_.size(), [&](std::size_t i) {
      if (rules_.finds_poses) {
        const auto T_odom_sensor = rules_.noise.is_there() ? std::optional(T_map_sensor) : std::nullopt;
        pilots_[i].take(aligned.scan, course_.time(scan), T_odom_sensor, aligned.T_map_sensor);
      } else {
        contenders_[i]->update(aligned.scan, T_map_sensor);
      }
      for (const Passer& passer : course_.passers()) {
        results_[i]["shown"][passer.name].push_back(
            share_seen(*contenders_[i], &Contender::claims, passer.p_map[scan]));
        results_[i]["noticed"][passer.name].push_back(
            share_seen(*contenders_[i], &Contender::notices, passer.p_map[scan]));
      }
    });
  }

  void measure(std::size_t scan) {
    const Truth truth = course_.truth(scan);
    side_by_side(contenders_.size(), [&](std::size_t i) {
      Json row = measure_surface(contenders_[i]->surface(), truth, course_.area, rules_.leaf);
      row["scan"] = course_.number(scan);
      results_[i]["rows"].push_back(std::move(row));
    });
  }

  Json finish() {
    const std::size_t last = course_.scans().size() - 1;
    const Truth truth = course_.truth(last);
    const Changes changes = course_.changes(rules_.leaf);
    side_by_side(contenders_.size(), [&](std::size_t i) {
      const Contender& contender = *contenders_[i];
      const Points map = contender.surface();
      results_[i]["end"] = measure_changes(contender, changes, course_.position_sigma);
      results_[i]["end"].update(measure_uncropped(map, truth, course_.area));
      results_[i]["end"]["memory_bytes"] = contender.memory_bytes();
      if (rules_.finds_poses) results_[i]["end"].update(pilots_[i].errors());
      if (rules_.at_end) results_[i]["end"].update(rules_.at_end(contender, map, truth));
      if (rules_.has_picture) results_[i]["picture"] = seen_from_above(map, truth, course_.view, rules_.leaf);
    });
    Json numbers = Json::array();
    for (std::size_t scan = 0; scan <= last; ++scan) numbers.push_back(course_.number(scan));
    return {{"scans", course_.scans().size()},
            {"scan_numbers", numbers},
            {"unchanged_points", changes.unchanged.size()},
            {"removed_points", changes.removed.size()},
            {"observed_points", truth.observed.size()},
            {"contenders", results_}};
  }

 private:
  /// Share of a passer's points in a scan that the map claims or notices after it; null when there are none.
  Json share_seen(const Contender& contender, bool (Contender::*says)(const Eigen::Vector3d&, double) const,
                  const Points& p_map) const {
    if (p_map.empty()) return nullptr;
    return share_true(p_map,
                      [&](const Eigen::Vector3d& p) { return (contender.*says)(p, course_.position_sigma); });
  }

  const Course& course_;
  const ContestRules& rules_;
  std::vector<std::unique_ptr<Contender>> contenders_;
  std::vector<Pilot> pilots_;  ///< when poses are to be found
  std::vector<Json> results_;
};

}  // namespace

Json hold_contest(const Course& course, std::vector<std::unique_ptr<Contender>> contenders,
                  const ContestRules& rules, const Progress& progress) {
  std::erase(contenders, nullptr);
  Contest contest(course, std::move(contenders), rules);
  const std::size_t scans = course.scans().size();
  const std::vector<std::size_t> measured = measured_scans(scans, rules.measurements);
  for (std::size_t scan = 0; scan < scans; ++scan) {
    contest.take(scan);
    if (std::binary_search(measured.begin(), measured.end(), scan)) contest.measure(scan);
    progress(scan + 1, scans);
  }
  return contest.finish();
}

std::vector<std::unique_ptr<Contender>> contenders_named(const std::vector<std::string>& names, double leaf,
                                                         const LidarParameters& lidar) {
  std::vector<std::unique_ptr<Contender>> contenders;
  contenders.reserve(names.size());
  for (const std::string& name : names) contenders.push_back(make_contender(name, leaf, lidar));
  return contenders;
}

std::vector<std::unique_ptr<Contender>> usual_contenders(double leaf, const LidarParameters& lidar) {
  std::vector<std::string> names = contender_names();
  std::erase(names, "OctoMap, voxel means");
  return contenders_named(names, leaf, lidar);
}

double number(const Json& json) {
  return json.is_number() ? json.get<double>() : std::numeric_limits<double>::quiet_NaN();
}

const Json* contender_of(const Json& result, const std::string& name) {
  for (const Json& contender : result["contenders"]) {
    if (contender["name"] == name) return &contender;
  }
  return nullptr;
}

std::vector<std::string> contenders_of(const Json& result) {
  std::vector<std::string> names;
  for (const Json& contender : result["contenders"]) names.push_back(contender["name"]);
  return names;
}

}  // namespace evermap
