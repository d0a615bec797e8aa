// SPDX-FileCopyrightText: 2026 the evermap authors
// SPDX-License-Identifier: BSD-3-Clause
#include <memory>
#include <optional>
#include <stdexcept>

#include <fmt/core.h>
#include <spdlog/spdlog.h>

#include "localized_run.hpp"
#include "options.hpp"
#include "posed_scans.hpp"
#include "report.hpp"
#include "verbs.hpp"
#include <evermap/files/file_error.hpp>
#include <evermap/history/map_store.hpp>
#include <evermap/io/detail/pose_log.hpp>

namespace evermap {
namespace {

struct LocalizeOptions {
  std::filesystem::path map;
  LocalizedScans scans;
  Pose initial_pose;  ///< of the first scan
  bool maintain = false;
  bool resume = false;
  std::optional<int> rollback;  ///< [scans]
  std::optional<double> max_contradicting;
  std::optional<double> search;  ///< [m]
  JournalParameters journal;
  double patience = 0;  ///< [s]
  std::filesystem::path poses;
  std::filesystem::path states;  ///< empty when not asked for
  std::filesystem::path map_out;
  std::filesystem::path report;  ///< folder; empty when not asked for
  ParameterOptions parameters;
  bool as_json = false;
};

void check(const LocalizeOptions& options) {
  check_writable(options.poses);
  if (!options.states.empty()) check_writable(options.states);
  if (options.maintain == options.map_out.empty()) {
    throw std::runtime_error("--maintain and --map-out need each other");
  }
  if (options.maintain) check_writable(options.map_out);
  if (!options.report.empty() && !options.maintain)
    throw std::runtime_error("--report tells what --maintain changes, and needs it");
  if (!options.report.empty()) prepare_report(options.report);
}

void run_localize(const LocalizeOptions& options) {
  Parameters parameters = parameters_of(options.parameters);
  parameters.lidar.scan_period = scan_period_of(options.scans, parameters.lidar.scan_period);
  parameters.rollback.scans = options.rollback.value_or(parameters.rollback.scans);
  parameters.localization.gate.max_contradicting =
      options.max_contradicting.value_or(parameters.localization.gate.max_contradicting);
  parameters.localization.relocation.reach =
      options.search.value_or(parameters.localization.relocation.reach);
  LocalizedScans scans = options.scans;
  if (options.resume) scans.before = poses_before(options.poses, scans.reading);
  check(options);
  std::optional<MapStore> store;
  if (options.maintain) store.emplace(options.map_out, options.patience);
  const bool goes_on = options.resume && store && std::filesystem::exists(options.map_out);
  const std::filesystem::path& start = goes_on ? options.map_out : options.map;
  Octree map = store ? load_start(start, *store) : load_map_version(start);
  if (map.empty()) throw std::runtime_error(options.map.string() + " has no leaves to localize in");
  MapMaintainer maintainer(std::move(map), parameters,
                           options.maintain ? MapMode::kMaintenance : MapMode::kLocalization,
                           scans.before.empty() ? options.initial_pose : scans.before.back().T_map_sensor);
  MapCause cause = cause_of("localize", options.scans.scans, parameters);
  std::optional<Octree> before;  // while it is kept, what the run changes is copied
  if (!options.report.empty()) before = maintainer.map();
  if (store) store->begin(maintainer.map(), cause, options.journal);
  PoseLog log(options.poses);
  const LocalizedRun run = localize_scans(
      scans, maintainer, parameters.lidar.scan_period,
      [&](const LocalizedRun& sofar) { acknowledge(&log, store ? &*store : nullptr, maintainer, sofar); });
  write_trajectory(options.poses, run);
  log.discard();
  if (!options.states.empty()) write_states(options.states, run);
  const bool is_left = store && run.run.stopped_by != 0 &&
                       leave_if_large(*store, maintainer.map(), options.journal, run.scans.size());
  if (store && !is_left) {
    cause.what +=
        fmt::format(", {} of {} scans tracked", run.count(TrackingState::kTracking), run.scans.size());
    put_in_place(*store, maintainer.map(), cause);
  }
  if (before && run.run.stopped_by == 0) {
    const Octree after = maintainer.map();
    const MapChange change(options.map_out, *before, after);
    Json json = to_json(change);
    json.update(to_json(run));
    write_report(options.report, json, change, *before, after);
  }
  if (options.as_json) {
    Json json = {{"poses", options.poses.string()}};
    if (options.maintain) json["map"] = options.map_out.string();
    json.update(to_json(run));
    fmt::print("{}", dump(json));
  } else {
    if (options.maintain) fmt::print("map      {}\n", options.map_out.string());
    fmt::print("poses    {}\n{}", options.poses.string(), to_text(run));
  }
  end_as(run.run);
  if (run.is_lost() || run.is_hardly_tracked()) {
    throw std::runtime_error(std::string("the robot was lost") +
                             (run.is_lost() ? " at the end" : " most of the time") +
                             "; try --initial-pose, a wider --search, or a map of this place");
  }
}

}  // namespace

void add_localize(CLI::App& app) {
  CLI::App* verb = app.add_subcommand("localize", "Find the poses of scans in a map, and keep it up to date");
  const auto options = std::make_shared<LocalizeOptions>();
  verb->add_option("MAP.evm", options->map, "Map to localize in")->required();
  add_scans_options(*verb, options->scans.scans, options->scans.reading);
  verb->add_option("-o,--output", options->poses,
                   "Poses to write, of the scans whose pose is believed: TUM, or .kitti, or .mcap")
      ->required()
      ->type_name("POSES.txt");
  add_pose_option(*verb, "--initial-pose", "Pose of the first scan, within 1 m and 10 degrees",
                  [options](const Pose& T_map_sensor) { options->initial_pose = T_map_sensor; })
      ->default_str("the map's origin");
  verb->add_option("--search", options->search, "How far around its last pose a lost robot is searched")
      ->check(CLI::Range(0.0, 100.0))
      ->type_name("METRES")
      ->default_str(fmt::format("{}", RelocationParameters{}.reach));
  verb->add_option("--states", options->states, "What was thought of each scan, and why, to write (CSV)")
      ->type_name("FILE.csv");
  add_odometry_options(*verb, options->scans, options->scans.reading);
  add_mount_options(*verb, options->scans.reading);
  verb->add_flag("--maintain", options->maintain, "Update the map with scans whose pose is believed");
  verb->add_option("--map-out", options->map_out,
                   "Map to write with --maintain; may be the one to start from")
      ->type_name("OUT.evm");
  add_report_option(*verb, options->report);
  verb->add_flag("--resume", options->resume,
                 "Go on with a run that was stopped or killed: after its last pose, in the map that it left");
  const RollbackParameters defaults;
  verb->add_option("--rollback", options->rollback,
                   "Scans whose changes are undone when the robot turns out to be lost")
      ->check(CLI::Range(0, 10000))
      ->type_name("SCANS")
      ->default_str(fmt::format("{}", defaults.scans));
  verb->add_option("--max-contradicting", options->max_contradicting,
                   "Fraction of a scan's rays, beyond the median of those before, that may contradict the "
                   "map; for a scan of more, other places are considered")
      ->check(CLI::Range(0.0, 1.0))
      ->type_name("FRACTION")
      ->default_str(fmt::format("{}", GateParameters{}.max_contradicting));
  add_sync_option(*verb, options->journal);
  add_threads_option(*verb, options->scans.threads);
  add_mode_option(*verb, options->parameters);
  add_range_options(*verb, options->parameters);
  add_config_option(*verb, options->parameters);
  add_wait_option(*verb, options->patience);
  add_json_option(*verb, options->as_json);
  verb->callback([options] { run_localize(*options); });
}

}  // namespace evermap
