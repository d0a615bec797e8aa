// SPDX-FileCopyrightText: 2026 the evermap authors
// SPDX-License-Identifier: BSD-3-Clause
#include "localized_run.hpp"

#include <algorithm>
#include <optional>
#include <utility>

#include <fmt/format.h>
#include <spdlog/spdlog.h>

#include <evermap/io/io_error.hpp>
#include <evermap/io/scan_source.hpp>
#include <evermap/scan/deskew.hpp>

namespace evermap {
namespace {

/// When each scan ended, and where the odometry saw it.
class Schedule {
 public:
  Schedule(const LocalizedScans& options, std::size_t scans) : rate_(options.rate) {
    if (options.odometry.empty()) return;
    poses_ = read_poses(options.odometry);
    if (poses_.size() == scans) return;
    throw IoError(options.odometry,
                  fmt::format("has {} poses for the {} scans of {}; give one pose for each scan",
                              poses_.size(), scans, options.scans.string()));
  }
  double time(std::size_t scan) const {
    const bool is_timed = !poses_.empty() && poses_[scan].time;
    return is_timed ? *poses_[scan].time : static_cast<double>(scan + 1) / rate_;
  }
  // NOLINTNEXTLINE(readability-identifier-naming): poses are named by their frames.
  std::optional<Pose> T_odom_sensor(std::size_t scan) const {
    return poses_.empty() ? std::nullopt : std::optional(poses_[scan].T_map_sensor);
  }

 private:
  double rate_;
  std::vector<StampedPose> poses_;
};

/// Follows the sensor through the map and keeps account of it.
class Follower {
 public:
  Follower(const LocalizedScans& options, std::size_t scans, const Octree& map, Localizer localizer,
           const Writing& writing)
      : schedule_(options, scans),
        duration_(1 / options.rate),
        map_(map),
        localizer_(std::move(localizer)),
        writing_(writing) {}

  ScanSummary follow(const Scan& raw) {
    const std::size_t index = result_.trajectory.size();
    const double time = schedule_.time(index);
    const std::optional<Pose> T_odom_sensor = schedule_.T_odom_sensor(index);
    const Scan scan = deskew(raw, localizer_.motion(time, T_odom_sensor, duration_), duration_);
    ScanSummary summary{.points = scan.p_sensor.size()};
    const WriteScan write = [&](const Pose& T_map_sensor) -> std::string {
      const auto written = writing_.write(scan, T_map_sensor);
      if (!written) return "contradicts too much of the map";
      summary = *written;
      return {};
    };
    if (map_.empty() && writing_.write) {  // the first scan makes the map and lies where it is put
      const Pose first = localizer_.predict(time, T_odom_sensor);
      write(first);
      record(time, {first, TrackingState::kStarting, {}, {}});
    } else {
      const auto was = localizer_.state();
      const Localization at =
          localizer_.localize(map_, scan, time, T_odom_sensor, writing_.write ? write : WriteScan{});
      record(time, at);
      if (at.state == TrackingState::kLost && was != at.state) result_.taken_back += writing_.take_back();
    }
    return summary;
  }

  LocalizedRun finish(Run run) {
    result_.run = std::move(run);
    return std::move(result_);
  }

 private:
  void record(double time, const Localization& at) {
    spdlog::debug("scan {}: {} {}, {:.0f} % inliers, residual {:.2f}, observability {:.2f}, {} iterations",
                  result_.trajectory.size(), to_string(at.state), at.objection,
                  100 * at.registration.inlier_share, at.registration.residual, at.registration.weakest.share,
                  at.registration.iterations);
    result_.trajectory.push_back({time, at.T_map_sensor});
    ++result_.states[static_cast<std::size_t>(at.state)];
    if (!at.objection.empty()) ++result_.objections[at.objection];
  }

  Schedule schedule_;
  double duration_;  ///< [s] of a scan
  const Octree& map_;
  Localizer localizer_;
  const Writing& writing_;
  LocalizedRun result_;
};

}  // namespace

void add_odometry_options(CLI::App& verb, LocalizedScans& options) {
  verb.add_option("--odometry", options.odometry,
                  "Poses of the sensor in a frame that may drift, one per scan (TUM or KITTI)")
      ->type_name("FILE");
  verb.add_option("--rate", options.rate, "Scans per second, where no odometry tells their times")
      ->check(CLI::Range(0.1, 1000.0))
      ->type_name("HZ");
}

LocalizedRun localize_scans(const LocalizedScans& options, const Octree& map, Localizer localizer,
                            const Writing& writing) {
  ScanSource scans(options.scans);
  Follower follower(options, scans.size(), map, std::move(localizer), writing);
  LocalizedRun result = follower.finish(run_over(scans.size(), options.threads, [&](const TakeScan& take) {
    const Scan scan = scans.next().value();
    take(scan, [&] { return follower.follow(scan); });
  }));
  if (!options.odometry.empty() && result.count(TrackingState::kTracking) == 0) {
    throw IoError(
        options.odometry,
        "no scan could be tracked with this odometry; is it of the LiDAR itself, its x axis ahead?");
  }
  return result;
}

Json to_json(const LocalizedRun& run) {
  Json states;
  for (std::size_t i = 0; i < run.states.size(); ++i) {
    states[std::string(to_string(static_cast<TrackingState>(i)))] = run.states[i];
  }
  Json json = {{"states", states}, {"objections", run.objections}, {"taken_back", run.taken_back}};
  json.update(to_json(run.run));
  return json;
}

std::string to_text(const LocalizedRun& run) {
  const double total = std::max<double>(1, static_cast<double>(run.run.scans_done));
  std::string text =
      fmt::format("states   {:.1f} % tracked: {} starting, {} tracking, {} degraded, {} lost\n",
                  100 * static_cast<double>(run.count(TrackingState::kTracking)) / total,
                  run.count(TrackingState::kStarting), run.count(TrackingState::kTracking),
                  run.count(TrackingState::kDegraded), run.count(TrackingState::kLost));
  for (const auto& [reason, scans] : run.objections) {
    text += fmt::format("         {} did not pass: {}\n", scans, reason);
  }
  if (run.taken_back > 0)
    text += fmt::format("         the changes of {} scans were taken back\n", run.taken_back);
  return text + to_text(run.run);
}

}  // namespace evermap
