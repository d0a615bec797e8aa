// SPDX-FileCopyrightText: 2026 the evermap authors
// SPDX-License-Identifier: BSD-3-Clause
#include <algorithm>
#include <cmath>
#include <utility>

#include <evermap/geometry/detail/for_each_index.hpp>
#include <evermap/localization/detail/coarse_map.hpp>
#include <evermap/localization/detail/correspondence.hpp>
#include <evermap/localization/detail/perturbation.hpp>
#include <evermap/localization/detail/relocation.hpp>

namespace evermap {
namespace {

constexpr double kCoarseEdge = 1.2;  ///< [m] leaves of the view that offsets are scored on, at least
constexpr std::size_t kCoarseBundles = 300;

struct Try {
  Pose T_map_sensor;
  double score = 0;
};

std::vector<Try> offsets(const Pose& last, const RelocationParameters& p) {
  std::vector<Try> tries;
  const int steps = static_cast<int>(std::floor(p.reach / p.step));
  const int turns = static_cast<int>(std::floor(p.turn / p.turn_step));
  for (int x = -steps; x <= steps; ++x) {
    for (int y = -steps; y <= steps; ++y) {
      for (int turn = -turns; turn <= turns; ++turn) {
        Twist offset = Twist::Zero();
        offset << p.step * x, p.step * y, 0, 0, 0, p.turn_step * turn;
        tries.push_back({perturb(last, offset)});
      }
    }
  }
  return tries;
}

/// How much of the scan lies on the map, in [0, bundles].
double score(const Octree& map, const std::vector<Gaussian>& bundles_sensor, const Pose& T_map_sensor) {
  double sum = 0;
  for (const auto& match : correspond(map, bundles_sensor, T_map_sensor)) {
    if (match) sum += std::exp(-0.5 * match->mahalanobis_squared);
  }
  return sum;
}

/// The best tries that are farther than `apart` [m] from better ones.
std::vector<Pose> finalists(std::vector<Try> tries, int count, double apart) {
  std::stable_sort(tries.begin(), tries.end(), [](const Try& a, const Try& b) { return a.score > b.score; });
  std::vector<Pose> best;
  for (const Try& next : tries) {
    if (static_cast<int>(best.size()) == count) break;
    const bool is_new = std::none_of(best.begin(), best.end(), [&](const Pose& better) {
      return (better.translation - next.T_map_sensor.translation).norm() < apart;
    });
    if (is_new) best.push_back(next.T_map_sensor);
  }
  return best;
}

}  // namespace

std::vector<Registration> places(const Octree& map, const Scan& scan, const Pose& T_map_sensor_last,
                                 const LidarParameters& lidar, const RegistrationParameters& registration,
                                 const RelocationParameters& parameters) {
  const std::vector<Octree> views = coarse_views(map, T_map_sensor_last.translation);
  const auto coarse = std::find_if(views.begin(), views.end(),
                                   [](const Octree& view) { return view.grid().edge >= kCoarseEdge; });
  const Octree& view = coarse == views.end() ? map : *coarse;
  const auto bundles = bundles_in_sensor_frame(scan, view.grid().edge, lidar, kCoarseBundles);
  std::vector<Try> tries = offsets(T_map_sensor_last, parameters);
  for_each_index(tries.size(), 1,
                 [&](std::size_t i) { tries[i].score = score(view, bundles, tries[i].T_map_sensor); });
  constexpr double kApart = 1.5;  // [m]
  std::vector<Registration> found;
  for (const Pose& start : finalists(std::move(tries), parameters.finalists, kApart)) {
    found.push_back(register_coarse_to_fine(map, scan, {start}, lidar, registration));
  }
  return found;
}

std::vector<Registration> places_beside(const Octree& map, const Scan& scan, const PoseEstimate& found,
                                        const LidarParameters& lidar,
                                        const RegistrationParameters& registration) {
  constexpr double kApart = 0.15;  // [m] registration reaches as far
  const RelocationParameters around{.reach = 0.6, .turn = 0, .step = 0.1, .turn_step = 1, .finalists = 5};
  const auto bundles = bundles_in_sensor_frame(scan, map.grid().edge, lidar);
  const auto few = bundles_in_sensor_frame(scan, map.grid().edge, lidar, registration.first_bundles);
  std::vector<Try> tries = offsets(found.T_map_sensor, around);
  std::erase_if(tries, [&](const Try& at) {
    return (at.T_map_sensor.translation - found.T_map_sensor.translation).norm() < kApart;
  });
  for_each_index(tries.size(), 1, [&](std::size_t i) {
    tries[i].score = equations_at(map, few, tries[i].T_map_sensor, {registration.last_kernel_width}).fit();
  });
  std::vector<Registration> beside;
  for (const Pose& start : finalists(std::move(tries), around.finalists, kApart)) {
    beside.push_back(register_bundles(map, bundles, {start, found.covariance}, registration));
  }
  return beside;
}

}  // namespace evermap
