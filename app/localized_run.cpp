// SPDX-FileCopyrightText: 2026 the evermap authors
// SPDX-License-Identifier: BSD-3-Clause
#include "localized_run.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <memory>
#include <numeric>
#include <optional>
#include <string_view>

#include <Eigen/Geometry>
#include <fmt/format.h>
#include <spdlog/spdlog.h>

#include "posed_scans.hpp"
#include <evermap/files/file_error.hpp>
#include <evermap/io/detail/atomic_file.hpp>
#include <evermap/io/detail/pose_log.hpp>
#include <evermap/io/scan_source.hpp>
#include <evermap/scan/detail/deskew.hpp>

namespace evermap {
namespace {

void record(LocalizedRun& run, ScanResult result) {
  spdlog::debug("scan {}: {} {}, {:.0f} % inliers, residual {:.2f}, {:.0f} % of the rays contradict the map",
                run.scans.size(), to_string(result.state), to_string(result.reject_reason),
                100 * result.inlier_fraction, result.residual,
                100 * result.contradicting_fraction.value_or(0));
  for (const ScanResult& earlier : result.confirmed)
    run.trajectory.push_back({earlier.time, earlier.T_map_sensor * run.T_sensor_base});
  if (result.is_believed()) run.trajectory.push_back({result.time, result.T_map_sensor * run.T_sensor_base});
  append(run.scans, std::move(result));
}

/// Of which frame poses are to be written, and where it is on the sensor.
void find_base(const ScanSource& scans, const ScanOptions& reading, const std::filesystem::path& path,
               LocalizedRun& run) {
  if (!scans.frame().empty()) run.frames.child = scans.frame();
  if (reading.base.empty()) return;
  const std::optional<Pose> T_sensor_base =
      reading.mount ? reading.mount->T_base_sensor.inverse() : scans.base_pose();
  if (!T_sensor_base) {
    throw FileError(path, "nothing tells where " + reading.base + " is on the sensor; give --extrinsic");
  }
  run.T_sensor_base = *T_sensor_base;
  run.frames.child = reading.base;
}

/// What to do about scans that were rejected.
std::string_view advice(RejectReason reason) {
  switch (reason) {
    case RejectReason::kUnobservable:
      return " (odometry would tell: --odometry)";
    case RejectReason::kAmbiguous:
      return " (tell where it is: --initial-pose)";
    case RejectReason::kTooFewMatches:
    case RejectReason::kTooFewInliers:
      return " (is the map of this place, --initial-pose right?)";
    case RejectReason::kTooFar:
    case RejectReason::kTurnedTooFar:
      return " (is --rate right, and the odometry of this sensor?)";
    case RejectReason::kOdometryJumps:
      return " (do wheels slip?)";
    default:
      return {};
  }
}

}  // namespace

void add_odometry_options(CLI::App& verb, LocalizedScans& options, ScanOptions& reading) {
  verb.add_option(
          "--odometry", options.odometry,
          "Poses of the sensor in a frame that may drift: a file (TUM or KITTI), or a topic or a frame "
          "of the bag, or none")
      ->type_name("FILE|TOPIC|FRAME")
      ->default_str("the frame odom of a bag, if there is one");
  reading.is_imu_wanted = true;
  const auto choose_imu = [&reading](const std::string& topic) {
    reading.is_imu_wanted = topic != "none";
    reading.imu = topic;
  };
  verb.add_option_function<std::string>(
          "--imu", choose_imu,
          "Topic of a bag's gyroscope (sensor_msgs/Imu), of use without odometry, or none")
      ->type_name("TOPIC")
      ->default_str("the only one");
  verb.add_option("--rate", options.rate, "Scans per second")
      ->check(CLI::Range(0.1, 1000.0))
      ->type_name("HZ")
      ->default_str("10");
  verb.add_option("--base-frame", reading.base,
                  "Write poses of this frame, which /tf_static or --extrinsic connects with the sensor")
      ->type_name("FRAME")
      ->default_str("the sensor's");
}

double scan_period_of(const LocalizedScans& options, double configured) {
  if (options.rate) return 1 / *options.rate;
  constexpr int kFirst = 8;  // scans
  ScanOptions reading = options.reading;
  reading.selection.every = 1;
  const std::unique_ptr<ScanSource> scans = open_scans(options.scans, reading);
  std::vector<double> spans;  // [s] from stamp to stamp, or, without stamps, of the points
  std::optional<double> last;
  for (int i = 0; i < kFirst; ++i) {
    const std::optional<Scan> scan = scans->next();
    if (!scan) break;
    if (scan->time && last) spans.push_back(*scan->time - *last);
    if (!scan->time && has_times(*scan))
      spans.push_back(*std::max_element(scan->time_offset.begin(), scan->time_offset.end()));
    last = scan->time;
  }
  if (spans.empty()) return configured;
  const auto middle = spans.begin() + static_cast<std::ptrdiff_t>(spans.size() / 2);
  std::nth_element(spans.begin(), middle, spans.end());
  constexpr double kClearly = 1.2;
  constexpr double kShortest = 0.02;  // [s] a sensor of 50 Hz
  constexpr double kLongest = 0.5;    // [s]
  const bool is_as_configured = *middle < kClearly * configured && configured < kClearly * *middle;
  if (is_as_configured || *middle < kShortest || *middle > kLongest) return configured;
  spdlog::warn("{}: its scans were taken for {:.3g} a second, as their times say; --rate says otherwise",
               options.scans.string(), 1 / *middle);
  return *middle;
}

LocalizedRun localize_scans(const LocalizedScans& options, MapMaintainer& maintainer, double scan_period,
                            const std::function<void(const LocalizedRun& run)>& look) {
  ScanOptions reading = options.reading;
  ScanPoses odometry = options.odometry.empty()     ? ScanPoses::odometry_of(options.scans, reading)
                       : options.odometry == "none" ? ScanPoses("", options.scans, reading)
                                                    : ScanPoses(options.odometry, options.scans, reading);
  if (reading.mount && odometry.empty()) {
    throw std::runtime_error("an extrinsic or a calibration tells nothing without --odometry or --poses");
  }
  const std::unique_ptr<ScanSource> scans = open_scans(options.scans, reading);
  LocalizedRun result;
  result.frames.frame = maintainer.map().frame().name;
  result.trajectory = options.before;
  result.before = options.before.size();
  std::string point_time;
  std::size_t backwards = 0;
  bool is_matched = false;
  constexpr double kRounded = 1e-6;  // [s] the last digit of a time in a file
  const double resumed = options.before.empty() ? -std::numeric_limits<double>::infinity()
                                                : *options.before.back().time + kRounded;
  double time = resumed;
  result.run = run_over(scans->size(), options.threads, [&](const TakeScan& take) {
    const std::optional<Scan> scan = scans->next();
    if (!scan) return false;
    if (!std::exchange(is_matched, true)) {
      odometry.match(*scans, options.scans, *scan);
      find_base(*scans, reading, options.scans, result);
      point_time = point_time_in_words(scans->notes());
    }
    const double by_count = static_cast<double>(scans->index() + 1) * scan_period;
    const double now = scan->time.value_or(odometry.time(*scans).value_or(by_count));
    const std::optional<Pose> T_odom_sensor = odometry.end_of(*scan, *scans);
    if (now <= time) {
      backwards += time > resumed ? 1 : 0;
      return true;
    }
    time = now;
    result.with_odometry += T_odom_sensor ? 1 : 0;
    const std::optional<Eigen::Matrix3d> R_inertial_sensor = scans->rotation_at(time);
    result.with_gyroscope += R_inertial_sensor ? 1 : 0;
    record(result, take([&] { return maintainer.process(*scan, time, T_odom_sensor, R_inertial_sensor); }));
    look(result);
    return true;
  });
  result.run.point_time = point_time;
  result.run.failure = scans->failure();
  for (const std::string& remark : scans->remarks()) spdlog::warn("{}: {}", options.scans.string(), remark);
  if (backwards > 0) {
    spdlog::warn("{}: {} scans are not later than the one before by their stamps; they were left out",
                 options.scans.string(), backwards);
  }
  const bool is_odometry_given = !options.odometry.empty() && !odometry.empty();
  if (is_odometry_given && result.with_odometry == 0 && !result.scans.empty()) {
    throw FileError(options.scans, options.odometry + " tells no pose at the time of any scan");
  }
  if (is_odometry_given && result.is_hardly_tracked()) {
    throw FileError(
        options.odometry,
        "hardly a scan could be tracked with this odometry; is it of the LiDAR itself, its x axis ahead?");
  }
  return result;
}

std::vector<StampedPose> poses_before(const std::filesystem::path& poses, const ScanOptions& reading) {
  const std::string kind = poses.extension().string();
  if (!reading.base.empty() || kind == ".mcap" || kind == ".kitti")
    throw std::runtime_error(
        "--resume goes on with TUM poses of the sensor: no --base-frame, .mcap or .kitti");
  const std::filesystem::path part = PoseLog::path_of(poses);
  std::error_code error;
  const bool was_killed = std::filesystem::exists(part, error);
  std::vector<StampedPose> before = read_trajectory(was_killed ? part : poses);
  if (!before.front().time) throw FileError(poses, "has no times, which --resume needs");
  spdlog::warn("{}: goes on after {} poses, the last at {:.3f} s", poses.string(), before.size(),
               *before.back().time);
  return before;
}

void acknowledge(PoseLog* log, MapStore* store, const MapMaintainer& maintainer, const LocalizedRun& run) {
  if (log != nullptr) log->extend(run.trajectory);
  const auto map = [&] { return maintainer.map(); };
  if (store != nullptr && acknowledge(*store, map, run.scans.size()) && log != nullptr) log->sync();
}

std::size_t LocalizedRun::count(TrackingState state) const {
  return static_cast<std::size_t>(
      std::count_if(scans.begin(), scans.end(), [&](const ScanResult& scan) { return scan.state == state; }));
}

std::map<RejectReason, std::size_t> LocalizedRun::rejections() const {
  std::map<RejectReason, std::size_t> count;
  for (const ScanResult& scan : scans) {
    if (scan.reject_reason != RejectReason::kNone) ++count[scan.reject_reason];
  }
  return count;
}

std::size_t LocalizedRun::rolled_back() const {
  return std::accumulate(scans.begin(), scans.end(), std::size_t{0},
                         [](std::size_t sum, const ScanResult& scan) { return sum + scan.rolled_back; });
}

bool LocalizedRun::is_hardly_tracked() const {
  constexpr std::size_t kHardly = 3;  // one in three
  return kHardly * (before + count(TrackingState::kTracking)) < before + scans.size();
}

std::pair<double, double> LocalizedRun::way() const {
  double believed = 0;
  double all = 0;
  std::optional<std::size_t> last;
  for (std::size_t i = 0; i < scans.size(); ++i) {
    if (!scans[i].is_believed()) continue;
    const Eigen::Vector3d& p_map = scans[i].T_map_sensor.translation;
    const double step = last ? (p_map - scans[*last].T_map_sensor.translation).norm() : 0;
    all += step;
    if (last && *last + 1 == i) believed += step;
    last = i;
  }
  return {believed, all};
}

void write_trajectory(const std::filesystem::path& path, const LocalizedRun& run) {
  if (path.extension() == ".mcap") {
    std::vector<Odometry> poses;
    for (const ScanResult& scan : run.scans) {
      if (!scan.is_believed()) continue;
      poses.push_back(
          {scan.time, scan.T_map_sensor * run.T_sensor_base, scan.covariance_of(run.T_sensor_base)});
    }
    write_odometry_bag(path, poses, run.frames);
  } else if (path.extension() != ".kitti") {
    write_tum_poses(path, run.trajectory);
  } else if (run.trajectory.size() == run.scans.size()) {
    write_kitti_poses(path, run.trajectory);
  } else {
    throw FileError(path,
                    fmt::format("{} of {} scans are not believed, and a file of KITTI has no times to tell "
                                "which; what is believed is in {} (TUM)",
                                run.scans.size() - run.trajectory.size(), run.scans.size(),
                                PoseLog::path_of(path.filename()).string()));
  }
}

void write_states(const std::filesystem::path& path, const LocalizedRun& run) {
  AtomicFile file(path);
  file.write(
      "time,state,reason,written,inliers,contradicting,unobservable,x,y,z,qx,qy,qz,qw,sigma_x,sigma_y,"
      "sigma_z,sigma_roll,sigma_pitch,sigma_yaw\n");
  for (const ScanResult& scan : run.scans) {
    const Eigen::Vector3d& t = scan.T_map_sensor.translation;
    const Eigen::Quaterniond q(scan.T_map_sensor.rotation);
    std::string row = fmt::format("{:.6f},{},{},{:d},{:.4f},{:.4f},\"{}\"", scan.time, to_string(scan.state),
                                  to_string(scan.reject_reason), scan.is_written, scan.inlier_fraction,
                                  scan.contradicting_fraction.value_or(0), scan.unobservable);
    for (const double value : {t.x(), t.y(), t.z()}) row += fmt::format(",{:.6f}", value);
    for (const double value : {q.x(), q.y(), q.z(), q.w()}) row += fmt::format(",{:.9f}", value);
    for (int i = 0; i < 6; ++i) row += fmt::format(",{:.6f}", std::sqrt(scan.covariance(i, i)));
    file.write(row + "\n");
  }
  file.commit();
}

Json to_json(const LocalizedRun& run) {
  Json states;
  for (const auto state :
       {TrackingState::kStarting, TrackingState::kTracking, TrackingState::kDegraded, TrackingState::kLost}) {
    states[std::string(to_string(state))] = run.count(state);
  }
  Json rejections = Json::object();
  for (const auto& [reason, scans] : run.rejections()) rejections[std::string(to_string(reason))] = scans;
  const auto [believed, all] = run.way();
  Json json = {{"states", states},
               {"rejections", rejections},
               {"rolled_back", run.rolled_back()},
               {"with_odometry", run.with_odometry},
               {"with_gyroscope", run.with_gyroscope},
               {"way", {{"length", all}, {"tracked", believed}}}};
  json.update(to_json(run.run));
  return json;
}

std::string to_text(const LocalizedRun& run) {
  const double total = std::max<double>(1, static_cast<double>(run.scans.size()));
  std::string text =
      fmt::format("states   {:.1f} % tracked: {} starting, {} tracking, {} degraded, {} lost\n",
                  100 * static_cast<double>(run.count(TrackingState::kTracking)) / total,
                  run.count(TrackingState::kStarting), run.count(TrackingState::kTracking),
                  run.count(TrackingState::kDegraded), run.count(TrackingState::kLost));
  const auto [believed, all] = run.way();
  text +=
      fmt::format("way      {:.1f} m, {:.1f} % of it tracked\n", all, all > 0 ? 100 * believed / all : 100);
  for (const auto& [reason, scans] : run.rejections()) {
    text += fmt::format("         {} rejected: {}{}\n", scans, to_string(reason), advice(reason));
  }
  const auto written =
      static_cast<std::size_t>(std::count_if(run.scans.begin(), run.scans.end(), [](const ScanResult& scan) {
        return scan.is_written && scan.state == TrackingState::kTracking;
      }));
  if (written > 0 && written < run.count(TrackingState::kTracking)) {
    text +=
        fmt::format("         {} tracked but not written: a direction of their pose was known too badly\n",
                    run.count(TrackingState::kTracking) - written);
  }
  if (run.with_gyroscope > 0) text += fmt::format("gyroscope for {} scans\n", run.with_gyroscope);
  if (run.with_odometry > 0) text += fmt::format("odometry for {} scans\n", run.with_odometry);
  if (const std::size_t undone = run.rolled_back(); undone > 0)
    text += fmt::format("         the changes of {} scans were rolled back\n", undone);
  return text + to_text(run.run);
}

}  // namespace evermap
