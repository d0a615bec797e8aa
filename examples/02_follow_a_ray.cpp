// SPDX-FileCopyrightText: 2026 the evermap authors
// SPDX-License-Identifier: BSD-3-Clause
// Which surfaces does a straight line meet? The map lists the occupied leaves along it, front to back.
#include <cstdio>
#include <vector>

#include <evermap/maintenance/survey.hpp>
#include <evermap/map/traversal.hpp>

using namespace evermap;

namespace {

/// Three parallel walls, 5, 10 and 15 m ahead, as a survey's cloud in the map frame.
Scan survey() {
  Scan cloud;
  for (const double x : {5.1, 10.1, 15.1}) {
    for (double y = -3; y < 3; y += 0.05) {
      for (double z = 0.05; z < 2; z += 0.05) cloud.p_sensor.emplace_back(x, y, z);
    }
  }
  return cloud;
}

}  // namespace

int main() {
  Octree map(VoxelGrid{.edge = 0.2});
  add_survey(map, survey(), Pose{});

  const Ray ray{.origin = {0, 0.1, 1.1}, .end = {20, 0.1, 1.1}};
  std::vector<double> entries;  // [m] from the ray's origin
  std::puts("   entry     exit   surface at [m]          occupancy [log-odds]");
  for_each_occupied(map, ray, [&](VoxelKey key, const Leaf& leaf, double entry, double exit) {
    const Eigen::Vector3d mean = map.gaussian(key, leaf).mean;
    std::printf("%6.2f m %6.2f m   (%6.2f %6.2f %6.2f)   %.2f\n", entry, exit, mean.x(), mean.y(), mean.z(),
                static_cast<double>(leaf.log_odds));
    entries.push_back(entry);
  });

  const bool front_to_back = entries.size() == 3 && entries[0] < entries[1] && entries[1] < entries[2];
  return front_to_back ? 0 : 1;
}
