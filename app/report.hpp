// SPDX-FileCopyrightText: 2026 the evermap authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstddef>
#include <filesystem>
#include <string>

#include <nlohmann/json.hpp>

#include "run.hpp"
#include <evermap/map/map_difference.hpp>
#include <evermap/map/octree.hpp>

namespace evermap {

using Json = nlohmann::ordered_json;

/// Leaves of a map by what is known of them.
struct LeafCounts {
  std::size_t occupied = 0;
  std::size_t pending = 0;

  explicit LeafCounts(const Octree& octree);
};

/// How a map differs from what it was.
struct MapChange {
  std::filesystem::path map;
  LeafCounts before;
  LeafCounts after;
  MapDifference difference;

  MapChange(std::filesystem::path map, const Octree& before, const Octree& after);
};

/// What an update did, for people and for machines.
struct ChangeReport {
  MapChange change;  ///< of the map that was written
  Run run;
};

Json to_json(const ScanResult::PointCounts& points);
Json to_json(const Run& run);
Json to_json(const MapChange& change);
Json to_json(const ChangeReport& report);

std::string to_text(const ScanResult::PointCounts& points);
std::string to_text(const Run& run);
std::string to_text(const MapChange& change);
std::string to_text(const ChangeReport& report);

/// What --report asks for: report.json, pictures from above (birds_eye.hpp), and the page with both maps,
/// which opens from disk. Throws FileError.
inline constexpr const char* kReportName = "report.json";
inline constexpr const char* kViewerName = "viewer.html";
void write_report(const std::filesystem::path& folder, const Json& report, const MapChange& change,
                  const Octree& before, const Octree& after);
/// Fails now when it could not be written. Throws FileError.
void prepare_report(const std::filesystem::path& folder);

/// With a line break at the end; what is no UTF-8 (in a path, say) is replaced.
std::string dump(const Json& json);
/// Throws FileError when the file cannot be written.
void write_json(const std::filesystem::path& path, const Json& json);

}  // namespace evermap
