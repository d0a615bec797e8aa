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
constexpr double kOnePlace = 1.0;  ///< [m] poses nearer than this are one place

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

bool is_one_place(const Pose& a, const Pose& b) { return (a.translation - b.translation).norm() < kOnePlace; }

/// The best tries that are not neighbours of better ones.
std::vector<Pose> finalists(std::vector<Try> tries, int count) {
  std::stable_sort(tries.begin(), tries.end(), [](const Try& a, const Try& b) { return a.score > b.score; });
  std::vector<Pose> best;
  for (const Try& next : tries) {
    if (static_cast<int>(best.size()) == count) break;
    const bool is_new = std::none_of(best.begin(), best.end(), [&](const Pose& better) {
      return (better.translation - next.T_map_sensor.translation).norm() < 1.5 * kOnePlace;
    });
    if (is_new) best.push_back(next.T_map_sensor);
  }
  return best;
}

/// The best of the registrations, unless another place is about as good.
Registration winner(std::vector<Registration> found, double rival) {
  const auto is_better = [](const Registration& a, const Registration& b) {
    return std::pair(a.converged(), a.inlier_fraction) < std::pair(b.converged(), b.inlier_fraction);
  };
  Registration best = *std::max_element(found.begin(), found.end(), is_better);
  const bool has_rival = std::any_of(found.begin(), found.end(), [&](const Registration& other) {
    return other.converged() && other.inlier_fraction > rival * best.inlier_fraction &&
           !is_one_place(other.T_map_sensor, best.T_map_sensor);
  });
  if (best.converged() && has_rival) best.reject_reason = RejectReason::kAmbiguous;
  return best;
}

}  // namespace

Registration relocate(const Octree& map, const Scan& scan, const Pose& T_map_sensor_last,
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
  std::vector<Registration> found;
  for (const Pose& start : finalists(std::move(tries), parameters.finalists)) {
    found.push_back(register_coarse_to_fine(map, scan, start, lidar, registration));
  }
  return winner(std::move(found), parameters.rival);
}

}  // namespace evermap
