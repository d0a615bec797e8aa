// SPDX-FileCopyrightText: 2026 the evermap authors
// SPDX-License-Identifier: BSD-3-Clause
#include <memory>
#include <optional>
#include <stdexcept>

#include <fmt/core.h>

#include "journaled_run.hpp"
#include "localized_run.hpp"
#include "options.hpp"
#include "report.hpp"
#include "verbs.hpp"
#include <evermap/files/file_error.hpp>
#include <evermap/history/map_store.hpp>
#include <evermap/io/detail/pose_log.hpp>

namespace evermap {
namespace {

struct BuildOptions {
  RunOptions run;
  LocalizedScans odometry;
  std::filesystem::path poses_out;  ///< empty when not asked for
  std::filesystem::path map;
  MapFrame frame;
  double leaf = 0;      ///< [m]
  double patience = 0;  ///< [s]
  JournalParameters journal{.scans = 0};
  bool resume = false;
  ParameterOptions parameters;
  bool as_json = false;
};

MapCause cause_of_build(const BuildOptions& options, const Parameters& parameters) {
  return cause_of("build of", options.run.scans, parameters);
}

/// An empty map, or that of the build which is to go on.
Octree begin_map(const BuildOptions& options, MapStore& store, const VoxelGrid& grid) {
  if (!options.resume) return Octree(grid, options.frame);
  Octree map = store.load();
  if (map.grid().edge != grid.edge)
    throw FileError(options.map, fmt::format("has leaves of {} m; -r must say the same", map.grid().edge));
  return map;
}

template <class RunReport>
void finish(const BuildOptions& options, MapStore& store, const Octree& octree, const MapCause& cause,
            const RunReport& run) {
  store.create(octree, cause);
  if (options.as_json) {
    Json json = {{"map", options.map.string()}, {"leaves", octree.leaf_count()}};
    json.update(to_json(run));
    fmt::print("{}", dump(json));
  } else {
    fmt::print("map      {}\nleaves   {}\n{}", options.map.string(), octree.leaf_count(), to_text(run));
  }
}

void build_from_poses(const BuildOptions& options, MapStore& store, const Parameters& parameters) {
  ScanOptions reading = options.run.reading;
  reading.is_imu_wanted = false;
  MapCause cause = cause_of_build(options, parameters);
  if (options.resume) reading.selection.skip = scans_before(options.map, cause);
  PosedScans scans(options.run.scans, options.run.poses, parameters.lidar.scan_period, reading);
  const VoxelGrid grid = VoxelGrid::around(scans.first_pose().translation, options.leaf);
  MapMaintainer maintainer(begin_map(options, store, grid), parameters, MapMode::kMapping);
  PoseCheck check(Octree(grid), parameters.lidar, scans.poses());
  const Run run = run_journaled(scans, options.run, maintainer, check, store, options.journal, cause,
                                reading.selection.skip);
  finish(options, store, maintainer.map(), cause, run);
  end_as(run);
}

/// LiDAR odometry: each scan is localized in the map of those before it. The first pose is the map's origin.
void build_without_poses(const BuildOptions& options, MapStore& store, Parameters parameters) {
  LocalizedScans scans = options.odometry;
  scans.scans = options.run.scans;
  scans.reading = options.run.reading;
  scans.threads = options.run.threads;
  if (options.resume) scans.before = poses_before(options.poses_out, scans.reading);
  parameters.lidar.scan_period = scan_period_of(scans, parameters.lidar.scan_period);
  MapMaintainer maintainer(begin_map(options, store, VoxelGrid{.edge = options.leaf}), parameters,
                           MapMode::kMapping, options.resume ? scans.before.back().T_map_sensor : Pose{});
  MapCause cause = cause_of_build(options, parameters);
  store.begin(maintainer.map(), cause, options.journal);
  std::optional<PoseLog> log;
  if (!options.poses_out.empty()) log.emplace(options.poses_out);
  const LocalizedRun run = localize_scans(
      scans, maintainer, parameters.lidar.scan_period,
      [&](const LocalizedRun& sofar) { acknowledge(log ? &*log : nullptr, &store, maintainer, sofar); });
  if (log) {
    write_trajectory(options.poses_out, run);
    log->discard();
  }
  if (run.run.stopped_by != 0) cause.scans = scans.before.size() + run.scans.size();
  finish(options, store, maintainer.map(), cause, run);
  end_as(run.run);
  if (run.is_lost() || run.is_hardly_tracked()) {
    throw std::runtime_error(fmt::format(
        "{} of {} scans could be tracked{}; this map shows only these. Give odometry (--odometry) or poses "
        "(--poses)",
        run.count(TrackingState::kTracking), run.scans.size(), run.is_lost() ? ", none at the end" : ""));
  }
}

void run_build(const BuildOptions& options) {
  check_leaf(options.leaf);
  if (options.resume && options.run.poses.empty() && options.poses_out.empty())
    throw std::runtime_error("--resume needs --poses, or the --poses-out of the build that is to go on");
  const Parameters parameters = parameters_of(options.parameters);
  check_writable(options.map);
  MapStore store(options.map, options.patience);
  if (!options.poses_out.empty()) check_writable(options.poses_out);
  options.run.poses.empty() ? build_without_poses(options, store, parameters)
                            : build_from_poses(options, store, parameters);
}

}  // namespace

void add_build(CLI::App& app) {
  CLI::App* verb = app.add_subcommand(
      "build", "Make a map from scans, whose poses are given and trusted, or found by LiDAR odometry");
  const auto options = std::make_shared<BuildOptions>();
  add_run_options(*verb, options->run);
  CLI::Option* poses = verb->get_option("--poses")->required(false);
  verb->add_option("--poses-out", options->poses_out,
                   "Poses found by LiDAR odometry, to write: TUM, or .kitti, or .mcap")
      ->excludes(poses)
      ->type_name("FILE");
  add_odometry_options(*verb, options->odometry, options->run.reading);
  verb->add_option("-o,--output", options->map, "Map to write")->required()->type_name("MAP.evm");
  verb->add_flag(
      "--resume", options->resume,
      "Go on with a build that was stopped or killed, after the last scan that MAP.evm has, or the last "
      "pose of --poses-out");
  add_sync_option(*verb, options->journal);
  add_leaf_option(*verb, options->leaf);
  add_frame_options(*verb, options->frame);
  add_range_options(*verb, options->parameters);
  add_config_option(*verb, options->parameters);
  add_wait_option(*verb, options->patience);
  add_json_option(*verb, options->as_json);
  verb->callback([options] { run_build(*options); });
}

}  // namespace evermap
