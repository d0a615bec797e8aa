// SPDX-FileCopyrightText: 2026 the evermap authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <array>
#include <cstddef>
#include <filesystem>
#include <functional>
#include <map>
#include <optional>
#include <string>
#include <vector>

#include <CLI/CLI.hpp>

#include "report.hpp"
#include "run.hpp"
#include <evermap/io/poses.hpp>
#include <evermap/localization/localizer.hpp>

namespace evermap {

/// Scans whose poses are to be found.
struct LocalizedScans {
  std::filesystem::path scans;
  std::filesystem::path
      odometry;      ///< one pose of the sensor for each scan, in any frame; empty when not given
  double rate = 10;  ///< [Hz] scans per second, where the odometry has no times
  int threads = 0;   ///< 0: one per core
};
/// Adds --odometry and --rate.
void add_odometry_options(CLI::App& verb, LocalizedScans& options);

/// What became of them.
struct LocalizedRun {
  Run run;
  std::vector<StampedPose> trajectory;            ///< T_map_sensor of every scan
  std::array<std::size_t, 4> states{};            ///< scans by TrackingState
  std::map<std::string, std::size_t> objections;  ///< scans that did not pass the gate, by reason
  std::size_t taken_back = 0;                     ///< scans whose changes were undone

  std::size_t count(TrackingState state) const { return states[static_cast<std::size_t>(state)]; }
};

/// What becomes of scans, their motion undone, whose poses are believed.
struct Writing {
  /// Returns none when it refuses to write. Empty: nothing is written.
  std::function<std::optional<ScanSummary>(const Scan& scan, const Pose& T_map_sensor)> write{};
  /// Undoes the last changes when the robot turns out to be lost, and says of how many scans.
  std::function<std::size_t()> take_back = [] { return std::size_t{0}; };
};

/// Localizes scan by scan in the map, which `writing` may change, until all are done or SIGINT or SIGTERM
/// came. A map without leaves begins with the first scan. Throws IoError when scans or odometry cannot be
/// read or do not belong together.
LocalizedRun localize_scans(const LocalizedScans& options, const Octree& map, Localizer localizer,
                            const Writing& writing);

Json to_json(const LocalizedRun& run);
std::string to_text(const LocalizedRun& run);

}  // namespace evermap
