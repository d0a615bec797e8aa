// SPDX-FileCopyrightText: 2026 the evermap authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <filesystem>
#include <functional>
#include <optional>
#include <string>
#include <vector>

#include <CLI/CLI.hpp>

#include <evermap/bags/scan_bag.hpp>
#include <evermap/history/map_store.hpp>
#include <evermap/maintenance/parameters.hpp>

namespace evermap {

/// Where an update's parameters come from: the mode's defaults, then the file, then the options.
struct ParameterOptions {
  std::string mode = "default";
  std::filesystem::path config;     ///< empty when not given
  std::optional<double> min_range;  ///< [m]
  std::optional<double> max_range;  ///< [m]
  std::vector<double> vehicle_box;  ///< [m] two corners in the sensor's frame; empty when not given
};
void add_mode_option(CLI::App& verb, ParameterOptions& options);
void add_config_option(CLI::App& verb, ParameterOptions& options);
void add_range_options(CLI::App& verb, ParameterOptions& options);
/// Throws FileError when the file is wrong, std::runtime_error when the ranges exclude every point.
Parameters parameters_of(const ParameterOptions& options);

/// How clouds and scans are to be read, where their files do not tell.
void add_cloud_options(CLI::App& verb, CloudOptions& options);

/// The scans that a verb works through, and with how many threads.
struct RunOptions {
  std::filesystem::path scans;
  ScanOptions reading;
  std::string poses;       ///< a file, or a topic or frame of a bag
  bool is_forced = false;  ///< use the poses even if they do not fit
  int threads = 0;         ///< 0: one per core
};
/// SCANS, --topic, and which part of them.
void add_scans_options(CLI::App& verb, std::filesystem::path& scans, ScanOptions& reading);
void add_run_options(CLI::App& verb, RunOptions& options);
/// An option of a pose, "x y z qx qy qz qw", which `take` is given.
CLI::Option* add_pose_option(CLI::App& verb, const std::string& name, const std::string& help,
                             std::function<void(const Pose& pose)> take);
/// --extrinsic and --calib: what poses or odometry are of, if not of the sensor.
void add_mount_options(CLI::App& verb, ScanOptions& reading);
void add_threads_option(CLI::App& verb, int& threads);

void add_leaf_option(CLI::App& verb, double& leaf);
/// Throws std::runtime_error when the leaf edge [m] is out of range.
void check_leaf(double leaf);

/// --map-frame and --origin, of a map that is made.
void add_frame_options(CLI::App& verb, MapFrame& frame);

/// The map that a run starts from: `map.evm`, or a version of it, `map.evm@3`. A run that changes the file
/// itself reads it through the store. Warns when the store had to bring something back.
Octree load_start(const std::filesystem::path& map, MapStore& store);

/// Commits what a run made of the map. Warns when another program was at the map meanwhile.
void put_in_place(MapStore& store, const Octree& map, const MapCause& cause);
/// Whether to write a map takes longer than who stops a program waits.
bool is_large(const Octree& map);
/// Has the journal written if that is due. Before it has begun, a signal ends the program at once: nothing is
/// lost then, and of a large map it takes long to begin.
bool acknowledge(MapStore& store, const std::function<Octree()>& map, std::size_t scans);
/// At the end of a run that was stopped, leaves a large map in its journal, and says so. False when it is to
/// be put in place as usual, as one that is small or has no journal.
bool leave_if_large(MapStore& store, const Octree& map, const JournalParameters& journal, std::size_t scans);
/// What a run is, for the history of the map that it changes.
MapCause cause_of(const std::string& verb, const std::filesystem::path& scans, const Parameters& parameters);
/// How many scans a map has of such a run that was stopped or killed, which is to go on; says so. Throws
/// FileError when the map was not left by one.
std::size_t scans_before(const std::filesystem::path& map, const MapCause& cause);
/// --sync
void add_sync_option(CLI::App& verb, JournalParameters& journal);
/// How long to wait for another process that changes the map.
void add_wait_option(CLI::App& verb, double& patience);

/// --report, a folder for report.json and pictures.
void add_report_option(CLI::App& verb, std::filesystem::path& folder);
void add_json_option(CLI::App& verb, bool& as_json);

/// Fails now, instead of after a long run, when `file` cannot be written. Throws FileError.
void check_writable(const std::filesystem::path& file);

}  // namespace evermap
