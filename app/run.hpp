// SPDX-FileCopyrightText: 2026 the evermap authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstddef>
#include <filesystem>
#include <functional>
#include <vector>

#include "posed_scans.hpp"
#include <evermap/update/map_updater.hpp>

namespace evermap {

/// What became of all points of a run.
struct PointCounts {
  std::size_t total = 0;
  std::size_t used = 0;
  std::size_t not_finite = 0;
  std::size_t at_origin = 0;    ///< of zero range
  std::size_t near = 0;         ///< below min_range
  std::size_t far = 0;          ///< above max_range
  std::size_t out_of_grid = 0;  ///< beyond the range of keys

  PointCounts() = default;
  PointCounts(const Scan& scan, const ScanSummary& summary);
  PointCounts& operator+=(const PointCounts& other);
};

/// Throws IoError naming the scan's `file` when none of its points was used.
void check_any_used(const PointCounts& points, const std::filesystem::path& file);

/// What a verb did with a sequence of scans.
struct Run {
  std::size_t scans_done = 0;
  std::size_t scans_total = 0;
  PointCounts points;
  std::vector<double> wall;  ///< [s] per scan, without reading its file
  std::vector<double> cpu;   ///< [s] per scan, of all threads together

  bool was_interrupted() const { return scans_done < scans_total; }
};

/// Works through a sequence of scans in an arena of that many threads (0: one per core), with a progress bar:
/// calls `next` until it has taken the last scan, or SIGINT or SIGTERM came; the scan in hand is always
/// finished. `next` reads a scan and hands it to its argument, with the work that is to be timed.
using Work = std::function<ScanSummary()>;
using TakeScan = std::function<PointCounts(const Scan& scan, const Work& work)>;
Run run_over(std::size_t scans, int threads, const std::function<void(const TakeScan& take)>& next);

/// The same for scans with poses. Throws IoError when a scan cannot be read or none of its points is used.
using UpdateMap = std::function<ScanSummary(const Scan& scan, const Pose& T_map_sensor)>;
Run run_over(PosedScans& scans, int threads, const UpdateMap& update);

}  // namespace evermap
