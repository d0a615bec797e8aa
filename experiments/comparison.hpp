// SPDX-FileCopyrightText: 2026 the evermap authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <functional>
#include <memory>
#include <string>
#include <vector>

#include "experiments/dataset.hpp"
#include "report.hpp"
#include <evermap/evaluation/mapper.hpp>

namespace evermap {

inline constexpr const char* kOctoMap = "OctoMap";
inline constexpr const char* kEvermap = "evermap default";

/// Told how much of a task is done.
using Progress = std::function<void(std::size_t done, std::size_t total)>;
using Mappers = std::vector<std::unique_ptr<Mapper>>;

/// Normal noise on the poses that mappers are given, per axis of each scan.
struct PoseNoise {
  double translation = 0;  ///< [m]
  double rotation = 0;     ///< [rad]
  std::uint64_t seed = 1;

  bool is_there() const { return translation > 0 || rotation > 0; }
};

struct ComparisonRules {
  double leaf;                   ///< [m]
  std::size_t measurements = 1;  ///< over the run, evenly spread, the last one at its end
  PoseNoise noise{};
  /// Mappers localize in their own maps. They are given the first pose alone, or, when there is noise, noisy
  /// poses for odometry.
  bool finds_poses = false;
  bool has_view = false;  ///< the result holds what each map looks like from above
  /// More that is measured at the end.
  std::function<Json(const Mapper&, const Points& map, const Truth&)> at_end{};
};

/// Lets mappers keep the same map over the same scans and measures them. Mappers work side by side in the
/// caller's TBB arena; the result does not depend on it. Mappers that are null are skipped.
///
/// The result: "scans", "scan_numbers", numbers of points that are measured on, and "mappers", of each its
/// "name", "version", metrics along the run ("rows") and at its end ("end"), what it showed and noticed of
/// each dynamic object by scan, and its "view" from above.
Json compare_mappers(const Dataset& dataset, Mappers mappers, const ComparisonRules& rules,
                     const Progress& progress);

/// The mappers of these names (mapper_names); null where one is not installed.
Mappers mappers_named(const std::vector<std::string>& names, double leaf, const LidarParameters& lidar);

/// All mappers that can be had, but those that only timing asks for.
Mappers usual_mappers(double leaf, const LidarParameters& lidar);

/// A metric at the end of a comparison; null when it was not measured.
Json at_end(const Json& result_of_mapper, const std::string& metric);

}  // namespace evermap
