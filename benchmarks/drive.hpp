// SPDX-FileCopyrightText: 2026 the evermap authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstddef>
#include <vector>

#include <evermap/map/octree.hpp>
#include <evermap/scan/scan.hpp>
#include <evermap/simulation/scenario_drive.hpp>
#include <evermap/simulation/shipped.hpp>
#include <evermap/update/detail/map_updater.hpp>

namespace evermap {

/// The scans of one simulated drive, each with the pose that it was taken from.
struct Drive {
  std::vector<Scan> scans;
  std::vector<Pose> T_map_sensor;
};

/// The first `count` scans of the drive through the quarry, or each so many one: 64 x 1024 beams, some 42,000
/// returns within 200 m.
inline Drive drive_through_quarry(std::size_t count, std::size_t every = 1) {
  const ScenarioDrive quarry(shipped_scenario("quarry"));
  Drive drive;
  for (std::size_t i = 0; i < count; ++i) {
    drive.T_map_sensor.push_back(quarry.T_map_sensor(i * every));
    drive.scans.push_back(quarry.scan(i * every).scan);
  }
  return drive;
}

/// A warm map: it has seen the whole drive.
inline Octree map_of(const Drive& drive, double edge) {
  Octree octree(VoxelGrid{.edge = edge});
  for (std::size_t i = 0; i < drive.scans.size(); ++i) {
    add(octree, condense(drive.scans[i], drive.T_map_sensor[i], octree.grid(), {}), UpdateParameters{});
  }
  return octree;
}

}  // namespace evermap
