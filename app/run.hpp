// SPDX-FileCopyrightText: 2026 the evermap authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstddef>
#include <filesystem>
#include <functional>
#include <string>
#include <vector>

#include "options.hpp"
#include "posed_scans.hpp"
#include <evermap/maintenance/detail/pose_check.hpp>
#include <evermap/maintenance/map_maintainer.hpp>

namespace evermap {

/// How many points were not used, and why.
std::string dropped_in_words(const ScanResult::PointCounts& points);

/// Throws FileError naming `file` when none of the points was used.
void check_any_used(const ScanResult::PointCounts& points, const std::filesystem::path& file);

/// What a verb did with a sequence of scans.
struct Run {
  std::size_t scans_done = 0;
  std::size_t scans_total = 0;
  int stopped_by = 0;           ///< the signal that ended it early; 0: none did
  std::string failure;          ///< why it ended early otherwise, with what was done; empty when it did not
  std::size_t scans_empty = 0;  ///< without any usable point; nothing came of them
  ScanResult::PointCounts points;
  std::string point_time;    ///< what the time of a point was taken for; empty when points have none
  std::vector<double> wall;  ///< [s] per scan, without reading its file
  std::vector<double> cpu;   ///< [s] per scan, of all threads together
};

/// From now on SIGINT, SIGTERM and SIGHUP are remembered instead of ending the program.
void catch_stop_signals();
/// They end the program again, at once.
void forget_stop_signals();
/// The one that came; 0: none did.
int stop_signal();

/// How many threads are meant; 0: one per core.
int thread_count(int threads);

/// Ends the program as the run ended, after all is saved: throws Interrupted, or std::runtime_error.
void end_as(const Run& run);

/// Works through a sequence of `scans` scans in an arena of that many threads (0: one per core), with a
/// progress bar: calls `next` until it says that there was none, or SIGINT or SIGTERM came; the scan in hand
/// is always finished. `next` reads a scan and hands its argument the work on it, which is timed.
using Work = std::function<ScanResult()>;
using TakeScan = std::function<ScanResult(const Work& work)>;
Run run_over(std::size_t scans, int threads, const std::function<bool(const TakeScan& take)>& next);

/// What the time of a scan's points was taken for; empty when they have none.
std::string point_time_in_words(const CloudNotes& notes);

/// Gives the maintainer all scans with their poses, and shows each to `look`, if there is one. Throws
/// FileError when a scan cannot be read, or when no point of any scan could be used.
using LookAtScan = std::function<void(const PosedScan& posed, const ScanResult& result)>;
Run run_over(PosedScans& scans, int threads, MapMaintainer& maintainer, const LookAtScan& look = {});

/// Shows scans to the check, which stops the run by FileError once it knows what is wrong with the poses.
LookAtScan check_poses(PoseCheck& check, const RunOptions& options);

}  // namespace evermap
