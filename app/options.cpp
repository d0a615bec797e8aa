// SPDX-FileCopyrightText: 2026 the evermap authors
// SPDX-License-Identifier: BSD-3-Clause
#include "options.hpp"

#include <stdexcept>

#include <fmt/format.h>
#include <spdlog/spdlog.h>
#include <xxhash.h>

#include <evermap/config/parameters_file.hpp>
#include <evermap/files/file_error.hpp>
#include <evermap/io/detail/atomic_file.hpp>
#include <evermap/io/detail/quaternion.hpp>
#include <evermap/io/map_file.hpp>

namespace evermap {

void add_mode_option(CLI::App& verb, ParameterOptions& options) {
  verb.add_option("--mode", options.mode, "Whose rules: evermap's, or the paper's as printed")
      ->check(CLI::IsMember({"default", "paper"}))
      ->capture_default_str();
}

void add_config_option(CLI::App& verb, ParameterOptions& options) {
  verb.add_option("--config", options.config, "Parameters; evermap config prints all")
      ->type_name("FILE.yaml");
}

void add_range_options(CLI::App& verb, ParameterOptions& options) {
  const LidarParameters defaults;
  verb.add_option("--min-range", options.min_range, "Nearer points are not used")
      ->check(CLI::NonNegativeNumber)
      ->type_name("M")
      ->default_str(fmt::format("{}", defaults.min_range));
  verb.add_option("--max-range", options.max_range, "Farther points are not used")
      ->check(CLI::NonNegativeNumber)
      ->type_name("M")
      ->default_str(fmt::format("{}", defaults.max_range));
  verb.add_option("--vehicle-box", options.vehicle_box,
                  "Points on the vehicle itself: opposite corners of a box in the sensor's frame")
      ->delimiter(',')
      ->expected(6)
      ->type_name("X,Y,Z,X,Y,Z")
      ->default_str("none");
}

Parameters parameters_of(const ParameterOptions& options) {
  Parameters parameters = options.mode == "paper" ? Parameters::paper() : Parameters{};
  if (!options.config.empty()) read_parameters(options.config, parameters);
  LidarParameters& lidar = parameters.lidar;
  lidar.min_range = options.min_range.value_or(lidar.min_range);
  lidar.max_range = options.max_range.value_or(lidar.max_range);
  if (!options.vehicle_box.empty()) lidar.vehicle_box = box_between(options.vehicle_box);
  if (lidar.min_range < lidar.max_range) return parameters;
  throw std::runtime_error(fmt::format("min range {} m is not below max range {} m; no point would be used",
                                       lidar.min_range, lidar.max_range));
}

void add_cloud_options(CLI::App& verb, CloudOptions& options) {
  verb.add_option("--format", options.format, "Format of the clouds, whatever their names: .bin, .pcd, ...")
      ->check(CLI::IsMember(cloud_extensions()).description(""))
      ->type_name(".EXT")
      ->default_str("told by the names");
  verb.add_option("--bin-fields", options.bin_fields, "float32 values a point in .bin files: x y z first")
      ->check(CLI::Range(3, 32))
      ->type_name("N")
      ->default_str("told by the file");
}

void add_scans_options(CLI::App& verb, std::filesystem::path& scans, ScanOptions& reading) {
  verb.add_option("SCANS", scans,
                  "Bag (.bag, .db3, .mcap, or their folder), folder of clouds (.bin, .pcd, .ply ...), or one")
      ->required();
  verb.add_option("--topic", reading.topic, "Point clouds of a bag to use")
      ->type_name("TOPIC")
      ->default_str("the only one");
  verb.add_option("--start", reading.selection.start,
                  "Leave out what was recorded before, counted from the first scan")
      ->check(CLI::NonNegativeNumber)
      ->type_name("S")
      ->capture_default_str();
  verb.add_option("--duration", reading.selection.duration, "Stop that long after --start")
      ->check(CLI::NonNegativeNumber)
      ->type_name("S")
      ->default_str("to the end");
  verb.add_option("--every", reading.selection.every, "Use each n-th scan")
      ->check(CLI::Range(1, 1000000))
      ->type_name("N")
      ->capture_default_str();
  verb.add_flag("--strict", reading.selection.is_strict,
                "Stop at the first damaged scan; otherwise up to a tenth are left out");
  add_cloud_options(verb, reading.cloud);
}

void add_run_options(CLI::App& verb, RunOptions& options) {
  add_scans_options(verb, options.scans, options.reading);
  verb.add_option("--poses", options.poses,
                  "Poses of the sensor in the map: a file (TUM or KITTI), or a topic or a frame of the bag")
      ->required()
      ->type_name("FILE|TOPIC|FRAME");
  add_mount_options(verb, options.reading);
  verb.add_flag("--force", options.is_forced, "Go on even if the scans do not fit together by these poses");
  add_threads_option(verb, options.threads);
}

CLI::Option* add_pose_option(CLI::App& verb, const std::string& name, const std::string& help,
                             std::function<void(const Pose& pose)> take) {
  constexpr int kNumbers = 7;
  const auto read = [name, take = std::move(take)](const std::vector<double>& v) {
    const auto rotation = rotation_from_file(Eigen::Quaterniond(v[6], v[3], v[4], v[5]));
    if (!rotation) throw std::runtime_error(name + ": the quaternion qx qy qz qw has not norm 1");
    take({*rotation, {v[0], v[1], v[2]}});
  };
  return verb.add_option_function<std::vector<double>>(name, read, help + ": \"x y z qx qy qz qw\"")
      ->delimiter(' ')
      ->expected(kNumbers)
      ->type_name("POSE");
}

void add_mount_options(CLI::App& verb, ScanOptions& reading) {
  CLI::Option* extrinsic =
      add_pose_option(verb, "--extrinsic", "Where the sensor is on the base whose poses are given",
                      [&reading](const Pose& T_base_sensor) {
                        reading.mount = {T_base_sensor, {}};
                      })
          ->default_str("they are the sensor's own, or the bag tells");
  verb.add_option_function<std::filesystem::path>(
          "--calib",
          [&reading](const std::filesystem::path& file) { reading.mount = read_kitti_calibration(file); },
          "Calibration of KITTI, whose poses are of a camera; the map is in the LiDAR's axes")
      ->type_name("calib.txt")
      ->excludes(extrinsic);
}

void add_threads_option(CLI::App& verb, int& threads) {
  verb.add_option("--threads", threads, "Threads to use")
      ->check(CLI::Range(1, 1024))
      ->type_name("N")
      ->default_str("all cores");
}

void add_leaf_option(CLI::App& verb, double& leaf) {
  verb.add_option("-r,--resolution", leaf,
                  fmt::format("Leaf edge, {} to {} m", kLeastLeafEdge, kGreatestLeafEdge))
      ->required()
      ->type_name("M");
}

void add_frame_options(CLI::App& verb, MapFrame& frame) {
  constexpr int kNumbers = 3;
  verb.add_option("--map-frame", frame.name, "Name of the map's frame, as in /tf")
      ->type_name("FRAME")
      ->capture_default_str();
  const auto read = [&frame](const std::vector<double>& v) {
    frame.origin = {v[0], v[1], v[2]};
    if (!frame.origin->is_sound()) throw std::runtime_error("--origin: no place on earth");
  };
  verb.add_option_function<std::vector<double>>(
          "--origin", read, "Where the map's origin is on earth, its x axis pointing east (WGS 84)")
      ->delimiter(',')
      ->expected(kNumbers)
      ->type_name("LAT,LON,ALT")
      ->default_str("unknown");
}

void check_leaf(double leaf) {
  if (is_leaf_edge(leaf)) return;
  throw std::runtime_error(fmt::format("a leaf edge of {} m is out of range; choose {} to {} m", leaf,
                                       kLeastLeafEdge, kGreatestLeafEdge));
}

Octree load_start(const std::filesystem::path& map, MapStore& store) {
  if (!store.recovered().empty()) spdlog::warn("{}: {}", store.path().string(), store.recovered());
  std::error_code error;
  return std::filesystem::equivalent(map, store.path(), error) ? store.load() : load_map_version(map);
}

void put_in_place(MapStore& store, const Octree& map, const MapCause& cause) {
  store.commit(map, cause);
  if (!store.met_another_program()) return;
  spdlog::warn("{}: another program put a map in its place during this run; that one is the version before",
               store.path().string());
}

bool is_large(const Octree& map) {
  constexpr std::size_t kLeaves = 4'000'000;  // 190 MB
  return map.leaf_count() > kLeaves;
}

bool acknowledge(MapStore& store, const std::function<Octree()>& map, std::size_t scans) {
  if (store.has_journal()) return store.acknowledge(map, scans);
  forget_stop_signals();
  const bool is_written = store.acknowledge(map, scans);
  catch_stop_signals();
  return is_written;
}

bool leave_if_large(MapStore& store, const Octree& map, const JournalParameters& journal, std::size_t scans) {
  if (!is_large(map) || journal.scans == 0) return false;
  const bool has_journal = store.has_journal();
  if (has_journal) store.leave(map, scans);
  spdlog::warn("{}: {}", store.path().string(),
               has_journal ? "what the run did is in its journal; whoever opens it next puts that in place"
                           : "stopped before anything was acknowledged; it is as it was");
  return true;
}

MapCause cause_of(const std::string& verb, const std::filesystem::path& scans, const Parameters& parameters) {
  const std::string yaml = to_yaml(parameters);
  return {fmt::format("{} {}", verb, scans.string()),
          fmt::format("{:016x}", XXH3_64bits(yaml.data(), yaml.size()))};
}

std::size_t scans_before(const std::filesystem::path& map, const MapCause& cause) {
  const char* advice = "; leave --resume out to begin with the first scan";
  if (!MapHistory::exists_for(map))
    throw FileError(map, std::string("has no history that a run could go on with") + advice);
  const MapCause last = MapHistory(map).versions().back().cause;
  if (last.scans == 0 || !last.what.starts_with(cause.what + ","))
    throw FileError(map, "was not left by such a run that was stopped, but by: " + last.what + advice);
  spdlog::warn("{}: goes on after {} scans", map.string(), last.scans);
  return last.scans;
}

void add_sync_option(CLI::App& verb, JournalParameters& journal) {
  verb.add_option(
          "--sync", journal.scans,
          "Whenever so many scans are done, and each second, what was done so far survives kill -9 and "
          "power cuts; 0: only at the end")
      ->check(CLI::Range(0, 1000000))
      ->type_name("SCANS")
      ->capture_default_str();
}

void add_wait_option(CLI::App& verb, double& patience) {
  verb.add_option("--wait", patience, "Wait that long for another process that changes the map")
      ->check(CLI::NonNegativeNumber)
      ->type_name("S")
      ->capture_default_str();
}

void add_report_option(CLI::App& verb, std::filesystem::path& folder) {
  verb.add_option(
          "--report", folder,
          "Folder for report.json, pictures of before, after and the change, and a page to look around in")
      ->type_name("DIR");
}

void add_json_option(CLI::App& verb, bool& as_json) {
  verb.add_flag("--json", as_json, "Print the result as one JSON object");
}

void check_writable(const std::filesystem::path& file) { AtomicFile never_committed(file); }

}  // namespace evermap
