// SPDX-FileCopyrightText: 2026 the evermap authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstddef>
#include <filesystem>
#include <functional>
#include <map>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include <CLI/CLI.hpp>

#include "report.hpp"
#include "run.hpp"
#include <evermap/bags/odometry_bag.hpp>
#include <evermap/history/map_store.hpp>
#include <evermap/io/detail/pose_log.hpp>
#include <evermap/io/poses.hpp>
#include <evermap/maintenance/map_maintainer.hpp>

namespace evermap {

/// Scans whose poses are to be found.
struct LocalizedScans {
  std::filesystem::path scans;
  ScanOptions reading;
  std::string odometry;        ///< poses of the sensor in any frame: a file, or a topic or frame of a bag
  std::optional<double> rate;  ///< [Hz] scans per second, when not the parameters' scan_period
  int threads = 0;             ///< 0: one per core
  std::vector<StampedPose> before;  ///< poses of an earlier run; scans up to the last are left out
};
/// Adds --odometry, --imu, --rate and --base-frame, of which `reading` is told what is to be read.
void add_odometry_options(CLI::App& verb, LocalizedScans& options, ScanOptions& reading);

/// What became of them.
struct LocalizedRun {
  Run run;
  std::vector<StampedPose> trajectory;  ///< T_map_base of the scans that are believed, and of no others
  Pose T_sensor_base;                   ///< the sensor itself, unless a base was asked for
  OdometryFrames frames;                ///< of these poses
  std::vector<ScanResult> scans;        ///< all
  std::size_t before = 0;               ///< poses of the run that this one goes on with
  std::size_t with_odometry = 0;        ///< scans whose pose the odometry told
  std::size_t with_gyroscope = 0;       ///< scans whose rotation a gyroscope told

  bool is_lost() const { return !scans.empty() && scans.back().state == TrackingState::kLost; }
  /// Less than a third of the scans: the trajectory and a map made along it are worth nothing.
  bool is_hardly_tracked() const;
  /// Lengths of the way [m]: where scan after scan was believed, and in all; gaps count as straight.
  std::pair<double, double> way() const;
  std::size_t count(TrackingState state) const;
  /// How many scans were not believed or not written, and why.
  std::map<RejectReason, std::size_t> rejections() const;
  /// Scans whose changes were undone.
  std::size_t rolled_back() const;
};

/// [s] How long a scan takes: what the user says, or else the scans' own times if they differ clearly from
/// `configured`, which is said then. Throws FileError when no scan can be read.
double scan_period_of(const LocalizedScans& options, double configured);

/// Gives the maintainer scan by scan until all are done or SIGINT or SIGTERM came. Throws FileError when
/// scans or odometry cannot be read or do not belong together. `scan_period` [s] tells the scans' times where
/// the odometry has none. Shows the run up to there to `look` after each scan.
LocalizedRun localize_scans(const LocalizedScans& options, MapMaintainer& maintainer, double scan_period,
                            const std::function<void(const LocalizedRun& run)>& look);

/// The poses of the run that is to go on and writes them to `poses`: of one that was killed, in POSES.part.
/// Throws FileError when they cannot be read, std::runtime_error where they are not such that a run can go on
/// with.
std::vector<StampedPose> poses_before(const std::filesystem::path& poses, const ScanOptions& reading);

/// Keeps what the run found up to here, as often as the store's journal asks for: in the log of its poses and
/// in the store, where there are any.
void acknowledge(PoseLog* log, MapStore* store, const MapMaintainer& maintainer, const LocalizedRun& run);

/// Writes the trajectory as its file's name says: .kitti, .mcap (a bag of ROS 2), or TUM. Throws FileError
/// when it cannot be written; KITTI's rows have no times, so that none may be missing.
void write_trajectory(const std::filesystem::path& path, const LocalizedRun& run);

/// A table with a row a scan: what was thought of it, and why. Throws FileError when it cannot be written.
void write_states(const std::filesystem::path& path, const LocalizedRun& run);

Json to_json(const LocalizedRun& run);
std::string to_text(const LocalizedRun& run);

}  // namespace evermap
