// SPDX-FileCopyrightText: 2026 the evermap authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstddef>
#include <vector>

#include <evermap/map/octree.hpp>
#include <evermap/scan/scan.hpp>
#include <evermap/simulation/simulator.hpp>
#include <evermap/simulation/yard.hpp>
#include <evermap/update/map_updater.hpp>

namespace evermap {

/// The scans of one simulated drive, each with the pose that it was taken from.
struct Drive {
  std::vector<Scan> scans;
  std::vector<Pose> T_map_sensor;
};

/// The first `count` scans of the drive through the yard, of `scene`; it starts anew where it ends.
inline Drive drive_through(const Yard& yard, const Scene& scene, std::size_t count) {
  const Simulator simulator(scene);
  Drive drive;
  for (std::size_t i = 0; i < count; ++i) {
    drive.T_map_sensor.push_back(yard.T_map_sensor[i % yard.T_map_sensor.size()]);
    drive.scans.push_back(simulator.scan(drive.T_map_sensor.back(), LidarModel{}, i));
  }
  return drive;
}

/// Points [m, map frame] of the whole surface of a scene, dense enough for leaves of 0.1 m.
inline std::vector<Eigen::Vector3d> survey_of(const Scene& scene) {
  constexpr double kSpacing = 0.05;  // [m]
  std::vector<Eigen::Vector3d> points;
  for (const SurfaceSample& sample : sample_surface(scene, kSpacing)) points.push_back(sample.p_map);
  return points;
}

/// The map that a survey makes.
inline Octree map_of(const std::vector<Eigen::Vector3d>& survey, double edge) {
  Octree octree(VoxelGrid{.edge = edge});
  Scan cloud;
  cloud.p_sensor = survey;
  add_cloud(octree, cloud, Pose{}, UpdateParameters{});
  return octree;
}

}  // namespace evermap
