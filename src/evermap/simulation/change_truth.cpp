// SPDX-FileCopyrightText: 2026 the evermap authors
// SPDX-License-Identifier: BSD-3-Clause
#include <algorithm>
#include <cmath>
#include <numbers>

#include <evermap/simulation/change_truth.hpp>
#include <evermap/simulation/surface_index.hpp>

namespace evermap {
namespace {

constexpr double kSameSurface = 0.01;  ///< [m] well below the range noise of a LiDAR

/// Unit vector `index` of `count` that are spread evenly over all directions (a Fibonacci sphere).
Eigen::Vector3d spread_direction(int index, int count) {
  const double z = 1 - (2 * index + 1.0) / count;
  const double azimuth = index * std::numbers::pi * (3 - std::sqrt(5.0));
  const double r = std::sqrt(1 - z * z);
  return {r * std::cos(azimuth), r * std::sin(azimuth), z};
}

/// True when the point is inside solids other than its own and farther than `depth` [m] from where they can
/// be seen: then the sphere of that radius around it is inside too.
bool buried_deeper_than(double depth, const Eigen::Vector3d& p_map, int object, const SurfaceIndex& index) {
  if (!index.buried(p_map, object)) return false;
  constexpr int kProbes = 200;
  for (int i = 0; i < kProbes; ++i) {
    if (!index.buried(p_map + depth * spread_direction(i, kProbes))) return false;
  }
  return true;
}

}  // namespace

ChangeTruth change_truth(const Scene& before, const Scene& now, double spacing, double changed_distance) {
  const SurfaceIndex index_before(before);
  const SurfaceIndex index_now(now);
  const double reach = std::max(changed_distance, kSameSurface);
  ChangeTruth truth;
  for (const auto& [p_map, object] : sample_surface(before, spacing)) {
    const double distance = index_now.distance(p_map, reach);
    if (distance <= kSameSurface && !index_now.buried(p_map, object)) truth.unchanged.push_back(p_map);
    if (distance > reach && !index_now.buried(p_map)) truth.removed.push_back(p_map);
  }
  for (const auto& [p_map, object] : sample_surface(now, spacing)) {
    truth.now.push_back(p_map);
    if (std::isinf(index_before.distance(p_map, reach)) ||
        buried_deeper_than(reach, p_map, object, index_before)) {
      truth.added.push_back(p_map);
    }
  }
  return truth;
}

}  // namespace evermap
