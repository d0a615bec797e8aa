// SPDX-FileCopyrightText: 2026 the evermap authors
// SPDX-License-Identifier: BSD-3-Clause
// Uses something compiled from each module.
#include <evermap/evaluation/octomap_baseline.hpp>
#include <evermap/evermap.hpp>
#include <evermap/simulation/simulator.hpp>

int main(int argc, char** argv) {
  if (argc != 2) return 2;
  evermap::Scene scene;
  evermap::add_box(scene, 1, evermap::Pose{}, {10, 10, 10});
  const evermap::Simulator simulator(scene);
  const evermap::Pose T_map_sensor{Eigen::Matrix3d::Identity(), {20, 0, 0}};
  evermap::MapMaintainer maintainer(evermap::Octree(evermap::VoxelGrid{.edge = 0.4}));
  const bool is_written = maintainer.process(simulator.scan(T_map_sensor, {}, 1), T_map_sensor).is_written;
  evermap::save_map(argv[1], maintainer.map());
  const evermap::OctoMapBaseline baseline(0.4);
  return is_written && !evermap::load_map(argv[1]).empty() && baseline.occupied_centers().empty() ? 0 : 1;
}
