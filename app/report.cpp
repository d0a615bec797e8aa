// SPDX-FileCopyrightText: 2026 the evermap authors
// SPDX-License-Identifier: BSD-3-Clause
#include "report.hpp"

#include <algorithm>
#include <cmath>
#include <numeric>
#include <utility>
#include <vector>

#include <fmt/format.h>

#include "birds_eye.hpp"
#include <evermap/io/detail/atomic_file.hpp>
#include <evermap/web/map_page.hpp>

namespace evermap {
namespace {

struct Spread {
  double mean = 0, median = 0, p99 = 0, max = 0;  ///< [s]

  explicit Spread(std::vector<double> times) {
    if (times.empty()) return;
    std::sort(times.begin(), times.end());
    const auto size = static_cast<double>(times.size());
    const auto quantile = [&](double share) {  // nearest rank
      return times[static_cast<std::size_t>(std::ceil(share * size)) - 1];
    };
    mean = std::accumulate(times.begin(), times.end(), 0.0) / size;
    median = quantile(0.5);
    p99 = quantile(0.99);
    max = times.back();
  }
};

Json to_json(const Spread& times) {
  return {{"mean", times.mean}, {"median", times.median}, {"p99", times.p99}, {"max", times.max}};
}

std::string to_text(const Spread& times) {
  return fmt::format("mean {:.1f} ms, median {:.1f} ms, 99 % {:.1f} ms, max {:.1f} ms", 1e3 * times.mean,
                     1e3 * times.median, 1e3 * times.p99, 1e3 * times.max);
}

}  // namespace

LeafCounts::LeafCounts(const Octree& octree) {
  octree.for_each_leaf([&](VoxelKey, const Leaf& leaf) { ++(leaf.occupied() ? occupied : pending); });
}

Json to_json(const ScanResult::PointCounts& points) {
  return {{"total", points.total},
          {"used", points.used},
          {"dropped",
           {{"not_finite", points.not_finite},
            {"at_origin", points.at_origin},
            {"nearer_than_min_range", points.near},
            {"on_the_vehicle", points.on_vehicle},
            {"farther_than_max_range", points.far},
            {"beyond_the_grid", points.out_of_grid}}}};
}

Json to_json(const Run& run) {
  return {{"scans",
           {{"done", run.scans_done},
            {"total", run.scans_total},
            {"empty", run.scans_empty},
            {"interrupted", run.stopped_by != 0}}},
          {"points", to_json(run.points)},
          {"point_time", run.point_time},
          {"seconds_per_scan", {{"wall", to_json(Spread(run.wall))}, {"cpu", to_json(Spread(run.cpu))}}}};
}

MapChange::MapChange(std::filesystem::path file, const Octree& octree_before, const Octree& octree_after)
    : map(std::move(file)),
      before(octree_before),
      after(octree_after),
      difference(compare(octree_before, octree_after)) {}

Json to_json(const MapChange& change) {
  return {{"map", change.map.string()},
          {"leaves",
           {{"before", change.before.occupied},
            {"after", change.after.occupied},
            {"added", change.difference.added.size()},
            {"removed", change.difference.removed.size()},
            {"moved", change.difference.moved.size()},
            {"border_added", change.difference.border_added},
            {"border_removed", change.difference.border_removed},
            {"pending", change.after.pending}}}};
}

Json to_json(const ChangeReport& report) {
  Json json = to_json(report.change);
  json.update(to_json(report.run));
  return json;
}

std::string to_text(const ScanResult::PointCounts& points) {
  return fmt::format("points   {} of {} used\ndropped  {}\n", points.used, points.total,
                     dropped_in_words(points));
}

std::string to_text(const Run& run) {
  const std::string interrupted =
      run.stopped_by != 0 ? fmt::format("interrupted after {} of {} scans\n", run.scans_done, run.scans_total)
                          : "";
  const std::string empty =
      run.scans_empty > 0 ? fmt::format("; {} without a usable point skipped", run.scans_empty) : "";
  return interrupted + fmt::format("scans    {} of {}{}\n", run.scans_done, run.scans_total, empty) +
         (run.point_time.empty() ? "" : "times    " + run.point_time + "\n") + to_text(run.points) +
         "wall     per scan: " + to_text(Spread(run.wall)) + "\n" +
         "CPU      per scan: " + to_text(Spread(run.cpu)) + "\n";
}

std::string to_text(const MapChange& change) {
  const MapDifference& difference = change.difference;
  return fmt::format(
      "map      {}\n"
      "leaves   {} before, {} after: {} added, {} removed, {} moved; {} more pending\n"
      "         {} more came and {} more went at the border of voxels, where the neighbouring leaf "
      "shows the same surface\n",
      change.map.string(), change.before.occupied, change.after.occupied, difference.added.size(),
      difference.removed.size(), difference.moved.size(), change.after.pending, difference.border_added,
      difference.border_removed);
}

std::string to_text(const ChangeReport& report) { return to_text(report.change) + to_text(report.run); }

void write_report(const std::filesystem::path& folder, const Json& report, const MapChange& change,
                  const Octree& before, const Octree& after) {
  write_json(folder / kReportName, report);
  write_pictures(folder, before, after, change.difference);
  AtomicFile file(folder / kViewerName);
  file.write(page_with_map(after, before, change.map.filename().string()));
  file.commit();
}

void prepare_report(const std::filesystem::path& folder) {
  make_folder(folder);
  const AtomicFile never_committed(folder / kReportName);
}

std::string dump(const Json& json) { return json.dump(2, ' ', false, Json::error_handler_t::replace) + "\n"; }

void write_json(const std::filesystem::path& path, const Json& json) {
  AtomicFile file(path);
  file.write(dump(json));
  file.commit();
}

}  // namespace evermap
