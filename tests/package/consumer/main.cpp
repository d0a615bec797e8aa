// SPDX-FileCopyrightText: 2026 the evermap authors
// SPDX-License-Identifier: BSD-3-Clause
// Uses something compiled from each module.
#include <evermap/evaluation/octomap_baseline.hpp>
#include <evermap/io/map_file.hpp>
#include <evermap/simulation/simulator.hpp>
#include <evermap/update/detail/map_updater.hpp>

int main(int argc, char** argv) {
  if (argc != 2) return 2;
  evermap::Scene scene;
  evermap::add_box(scene, 1, evermap::Pose{}, {10, 10, 10});
  const evermap::Simulator simulator(scene);
  const evermap::Pose T_map_sensor{Eigen::Matrix3d::Identity(), {20, 0, 0}};
  evermap::Octree octree(evermap::VoxelGrid{.edge = 0.4});
  const evermap::Scan scan = simulator.scan(T_map_sensor, {}, 1);
  evermap::add_scan(octree, scan, T_map_sensor, {});
  evermap::update(octree, scan, T_map_sensor, {});
  evermap::save_map(argv[1], octree);
  const evermap::OctoMapBaseline baseline(0.4);
  return !octree.empty() && baseline.occupied_centers().empty() ? 0 : 1;
}
