// SPDX-FileCopyrightText: 2026 the evermap authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <vector>

#include <evermap/geometry/detail/degree.hpp>
#include <evermap/map/octree.hpp>
#include <evermap/simulation/scenario_drive.hpp>
#include <evermap/simulation/simulator.hpp>
#include <evermap/update/detail/map_updater.hpp>

namespace evermap::test {

inline constexpr double kPeriod = 0.1;  ///< [s] of a scan

/// The demo's world and drive.
inline const ScenarioDrive& yard() {
  static const ScenarioDrive drive(shipped_scenario("yard"));
  return drive;
}

/// A sensor with fewer beams, for speed.
inline LidarModel small_lidar() {
  LidarModel lidar;
  lidar.channels = 32;
  lidar.columns = 512;
  lidar.max_range = 100;
  return lidar;
}

/// The map that a survey of the scene makes.
inline Octree survey_map(const Scene& scene, double edge, double spacing = 0.1) {
  Octree octree(VoxelGrid{.edge = edge});
  Scan cloud;
  for (const SurfaceSample& sample : sample_surface(scene, spacing)) cloud.p_sensor.push_back(sample.p_map);
  add_cloud(octree, cloud, Pose{}, {}, {});
  return octree;
}

/// An endless corridor along `yaw`, 4 m wide and high; as far as the sensor sees, that is.
inline Scene corridor(double yaw = 0) {
  Scene scene;
  Pose T_map_box;
  T_map_box.rotation = Eigen::AngleAxisd(yaw, Eigen::Vector3d::UnitZ()).toRotationMatrix();
  add_box(scene, 1, T_map_box, {300, 4, 4});
  return scene;
}

/// Flat ground, and nothing else.
inline Scene plane() {
  Scene scene;
  Pose T_map_box;
  T_map_box.translation.z() = -2.7;  // its bottom is not to share leaves with its top
  add_box(scene, 1, T_map_box, {100, 100, 2});
  return scene;
}

}  // namespace evermap::test
