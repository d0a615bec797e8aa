// SPDX-FileCopyrightText: 2026 the evermap authors
// SPDX-License-Identifier: BSD-3-Clause
#include "localized_run.hpp"

#include <chrono>
#include <csignal>
#include <ctime>
#include <optional>

#include <fmt/format.h>
#include <oneapi/tbb/global_control.h>
#include <oneapi/tbb/info.h>
#include <oneapi/tbb/task_arena.h>
#include <spdlog/spdlog.h>

#include "progress_bar.hpp"
#include <evermap/io/io_error.hpp>
#include <evermap/io/scan_source.hpp>
#include <evermap/scan/deskew.hpp>

namespace evermap {
namespace {

// A signal handler can reach nothing but a global.
volatile std::sig_atomic_t g_stop_requested = 0;
void request_stop(int) { g_stop_requested = 1; }

double cpu_seconds() { return static_cast<double>(std::clock()) / CLOCKS_PER_SEC; }
double wall_seconds() {
  return std::chrono::duration<double>(std::chrono::steady_clock::now().time_since_epoch()).count();
}

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

ScanSummary take(const Scan& raw, std::size_t index, const Schedule& schedule, double duration,
                 const Octree& map, Localizer& localizer, const TakeScan& write, LocalizedRun& result) {
  const double time = schedule.time(index);
  const std::optional<Pose> T_odom_sensor = schedule.T_odom_sensor(index);
  const Scan scan = deskew(raw, localizer.motion(time, T_odom_sensor, duration), duration);
  if (map.empty() && write) {  // the first scan makes the map and lies where it is put
    const Pose first = localizer.predict(time, T_odom_sensor);
    result.trajectory.push_back({time, first});
    ++result.states[static_cast<std::size_t>(TrackingState::kStarting)];
    return write(scan, first);
  }
  const Localization at = localizer.localize(map, scan, time, T_odom_sensor);
  result.trajectory.push_back({time, at.T_map_sensor});
  ++result.states[static_cast<std::size_t>(at.state)];
  if (!at.objection.empty()) ++result.objections[at.objection];
  spdlog::debug("scan {}: {} {}, {:.0f} % inliers, residual {:.2f}, observability {:.2f}, {} iterations",
                index, to_string(at.state), at.objection, 100 * at.registration.inlier_share,
                at.registration.residual, at.registration.weakest.share, at.registration.iterations);
  const bool may_write = localizer.may_update() && write;
  return may_write ? write(scan, at.T_map_sensor) : ScanSummary{.points = scan.p_sensor.size()};
}

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
                            const TakeScan& write) {
  ScanSource scans(options.scans);
  const Schedule schedule(options, scans.size());
  std::signal(SIGINT, request_stop);
  std::signal(SIGTERM, request_stop);
  const int threads = options.threads > 0 ? options.threads : oneapi::tbb::info::default_concurrency();
  // Without the first, TBB would never start more workers than there are cores.
  const oneapi::tbb::global_control limit(oneapi::tbb::global_control::max_allowed_parallelism,
                                          static_cast<std::size_t>(threads));
  oneapi::tbb::task_arena arena(threads);
  LocalizedRun result;
  result.run.scans_total = scans.size();
  const ProgressBar bar(scans.size());
  while (!g_stop_requested) {
    const std::optional<Scan> scan = scans.next();
    if (!scan) break;
    const double wall = wall_seconds();
    const double cpu = cpu_seconds();
    const ScanSummary summary = arena.execute([&] {
      return take(*scan, result.run.scans_done, schedule, 1 / options.rate, map, localizer, write, result);
    });
    result.run.wall.push_back(wall_seconds() - wall);
    result.run.cpu.push_back(cpu_seconds() - cpu);
    result.run.points += PointCounts(*scan, summary);
    bar.show(++result.run.scans_done);
  }
  return result;
}

Json to_json(const LocalizedRun& run) {
  Json states;
  for (std::size_t i = 0; i < run.states.size(); ++i) {
    states[std::string(to_string(static_cast<TrackingState>(i)))] = run.states[i];
  }
  Json json = {{"states", states}, {"objections", run.objections}};
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
  return text + to_text(run.run);
}

}  // namespace evermap
