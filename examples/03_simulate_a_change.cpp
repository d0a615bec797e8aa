// SPDX-FileCopyrightText: 2026 the evermap authors
// SPDX-License-Identifier: BSD-3-Clause
// A box stands before a wall when the map is made and is gone later: the map forgets it and keeps the wall.
#include <cstdint>
#include <cstdio>

#include <evermap/evermap.hpp>
#include <evermap/simulation/simulator.hpp>

using namespace evermap;

namespace {

const Eigen::AlignedBox3d kBox{Eigen::Vector3d(4.5, -1, 0.5), Eigen::Vector3d(6.5, 1, 2)};  ///< [m] map frame
const Eigen::AlignedBox3d kWall{Eigen::Vector3d(-30, 8, -4), Eigen::Vector3d(40, 9, 6)};

void add_solid(Scene& scene, int object, const Eigen::AlignedBox3d& extent) {
  Pose T_map_box;
  T_map_box.translation = extent.center();
  add_box(scene, object, T_map_box, extent.sizes());
}

/// The vehicle passes the box, its sensor 1.7 m above the ground.
Pose pose_at(int step) { return {Eigen::Matrix3d::Identity(), {0.5 * step, -6, 1.7}}; }

std::size_t occupied_leaves(const Octree& map, const Eigen::AlignedBox3d& solid) {
  const Eigen::Vector3d margin = Eigen::Vector3d::Constant(0.2);  // [m] for range noise
  const Eigen::AlignedBox3d extent(solid.min() - margin, solid.max() + margin);
  std::size_t count = 0;
  map.for_each_leaf([&](VoxelKey key, const Leaf& leaf) {
    count += leaf.occupied() && extent.contains(map.gaussian(key, leaf).mean);
  });
  return count;
}

}  // namespace

int main() {
  Scene scene;
  add_solid(scene, 1, kWall);
  const Simulator now(scene);
  add_solid(scene, 2, kBox);
  const Simulator earlier(scene);

  constexpr int kScans = 20;
  MapMaintainer mapper(Octree(VoxelGrid{.edge = 0.4}), {}, MapMode::kMapping);
  for (int i = 0; i < kScans; ++i) mapper.process(earlier.scan(pose_at(i), {}, 1), pose_at(i));
  Octree map = mapper.map();
  const std::size_t box_before = occupied_leaves(map, kBox);
  const std::size_t wall_before = occupied_leaves(map, kWall);
  MapMaintainer maintainer(map);
  for (int i = 0; i < kScans; ++i) maintainer.process(now.scan(pose_at(i), {}, 2), pose_at(i));
  map = maintainer.map();
  const std::size_t box_after = occupied_leaves(map, kBox);
  const std::size_t wall_after = occupied_leaves(map, kWall);

  std::printf("leaves of the box   %4zu before, %4zu after\n", box_before, box_after);
  std::printf("leaves of the wall  %4zu before, %4zu after\n", wall_before, wall_after);
  return box_before > 30 && box_after == 0 && wall_after >= wall_before ? 0 : 1;
}
