// SPDX-FileCopyrightText: 2026 the evermap authors
// SPDX-License-Identifier: BSD-3-Clause
#include "experiments/dataset.hpp"

#include <algorithm>
#include <cstdint>
#include <iterator>
#include <unordered_set>

#include <evermap/geometry/voxel_key.hpp>

namespace evermap {

std::vector<ScanRays> Dataset::rays() const {
  std::vector<ScanRays> rays;
  for (const auto& [scan, T_map_sensor] : scans_) {
    rays.push_back({T_map_sensor.translation, {}});
    for (const Eigen::Vector3d& p_sensor : scan.p_sensor) {
      const double range = p_sensor.norm();
      if (range < lidar.min_range || range > lidar.max_range) continue;
      rays.back().ends.emplace_back(T_map_sensor * p_sensor);
    }
  }
  return rays;
}

Points thinned(const Points& points, double edge) {
  const VoxelGrid grid{.edge = edge};
  std::unordered_set<std::uint64_t> taken;
  Points kept;
  for (const Eigen::Vector3d& p : points) {
    const auto key = grid.key(p);
    if (key && taken.insert(key->bits()).second) kept.push_back(p);
  }
  return kept;
}

Points within(const Eigen::AlignedBox2d& area, const Points& points) {
  Points inside;
  std::copy_if(points.begin(), points.end(), std::back_inserter(inside),
               [&](const Eigen::Vector3d& p) { return area.contains(p.head<2>()); });
  return inside;
}

}  // namespace evermap
