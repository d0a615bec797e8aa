// SPDX-FileCopyrightText: 2026 the evermap authors
// SPDX-License-Identifier: BSD-3-Clause
// A map of a wall is brought up to date by scans that see through a hole in it: the leaves there go.
#include <cstdio>

#include <evermap/evermap.hpp>

using namespace evermap;

namespace {

/// A scan taken in the origin: a wall 10 m ahead and, where it has its hole, the one 5 m behind.
Scan look_at_wall(bool with_hole) {
  Scan scan;
  for (double y = -2; y < 2; y += 0.04) {
    for (double z = -1; z < 1; z += 0.04) {
      const bool through = with_hole && y >= -0.6 && y < 0.6 && z >= -0.6 && z < 0.6;
      scan.p_sensor.push_back(Eigen::Vector3d(10.1, y, z) * (through ? 1.5 : 1));
    }
  }
  return scan;
}

}  // namespace

int main() {
  const Pose T_map_sensor;  // the sensor stands in the origin of the map frame

  MapMaintainer mapper(Octree(VoxelGrid::around(T_map_sensor.translation, 0.2)), {}, MapMode::kMapping);
  for (int i = 0; i < 5; ++i) mapper.process(look_at_wall(false), T_map_sensor);
  const Octree before = mapper.map();

  MapMaintainer maintainer(before);
  for (int i = 0; i < 10; ++i) maintainer.process(look_at_wall(true), T_map_sensor);
  const Octree map = maintainer.map();

  const MapDifference changes = compare(before, map);
  std::printf("leaves before  %zu\n", before.leaf_count());
  std::printf("removed        %zu, the hole\n", changes.removed.size());
  std::printf("added          %zu, the wall behind it\n", changes.added.size());

  save_map("updated.evm", map);
  const bool saved = load_map("updated.evm").leaf_count() == map.leaf_count();

  constexpr std::size_t kHole = 6 * 6;  // 1.2 m x 1.2 m in leaves of 0.2 m
  return saved && changes.removed.size() == kHole && !changes.added.empty() ? 0 : 1;
}
