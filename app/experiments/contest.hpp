// SPDX-FileCopyrightText: 2026 the evermap authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <functional>
#include <memory>
#include <string>
#include <vector>

#include "experiments/course.hpp"
#include "report.hpp"
#include <evermap/evaluation/contender.hpp>

namespace evermap {

/// Told how much of a task is done.
using Progress = std::function<void(std::size_t done, std::size_t total)>;

/// Normal noise on the poses that contenders are given, per axis of each scan.
struct PoseNoise {
  double translation = 0;  ///< [m]
  double rotation = 0;     ///< [rad]
  std::uint64_t seed = 1;

  bool is_there() const { return translation > 0 || rotation > 0; }
};

struct ContestRules {
  double leaf;                   ///< [m]
  std::size_t measurements = 1;  ///< over the run, evenly spread, the last one at its end
  PoseNoise noise{};
  /// Contenders localize in their own maps. They are given the first pose alone, or, when there is noise,
  /// noisy poses for odometry.
  bool finds_poses = false;
  bool has_picture = false;  ///< the result holds what each map looks like from above
  /// More that is measured at the end.
  std::function<Json(const Contender&, const Points& map, const Truth&)> at_end{};
};

/// Lets contenders keep the same map over the same scans, in turns, and measures them. Contenders work side
/// by side in the caller's TBB arena; the result does not depend on it.
///
/// The result names each contender and gives its measures along the run ("rows") and at the end ("end").
/// Contenders that are null are skipped.
Json hold_contest(const Course& course, std::vector<std::unique_ptr<Contender>> contenders,
                  const ContestRules& rules, const Progress& progress);

/// The contenders of these names (contender_names); null where one is not installed.
std::vector<std::unique_ptr<Contender>> contenders_named(const std::vector<std::string>& names, double leaf,
                                                         const LidarParameters& lidar);

/// All contenders that can be had, but those that only timing asks for.
std::vector<std::unique_ptr<Contender>> usual_contenders(double leaf, const LidarParameters& lidar);

/// The same number or NaN: JSON has no NaN and says null.
double number(const Json& json);

/// What a result says of a contender; nullptr when it was not there.
const Json* contender_of(const Json& result, const std::string& name);

/// The names of a result's contenders, in order.
std::vector<std::string> contenders_of(const Json& result);

}  // namespace evermap
