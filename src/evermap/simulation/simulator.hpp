// SPDX-FileCopyrightText: 2026 the evermap authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <optional>
#include <vector>

#include <Eigen/Core>

#include <evermap/geometry/pose.hpp>
#include <evermap/scan/scan.hpp>
#include <evermap/simulation/lidar_model.hpp>
#include <evermap/simulation/ray_caster.hpp>
#include <evermap/simulation/scene.hpp>

namespace evermap {

/// Where a beam met a surface, without noise.
struct BeamHit {
  int beam;               ///< see LidarModel::direction
  int object;             ///< id of the solid
  double range;           ///< [m]
  Eigen::Vector3d p_map;  ///< [m]
};

/// Looks at a scene with a LiDAR. Thread safe after construction.
class Simulator {
 public:
  /// Copies what it needs of the scene. Throws std::runtime_error when the ray caster cannot be set up.
  explicit Simulator(const Scene& scene);

  /// One revolution with the sensor held still. Ranges carry normal noise that depends on `seed` and the beam
  /// alone: the same arguments give the same scan, bit by bit and in any thread. Another machine may differ
  /// in the last bit where its sine, cosine or logarithm does, and at beams that graze the very edge of a
  /// thing. The scan's pose and times stay empty: the simulated sensor does not know where it is and does not
  /// move meanwhile.
  Scan scan(const Pose& T_map_sensor, const LidarModel& lidar, std::uint64_t seed) const;

  /// The returns of one revolution as they truly are, in the order of the scan's points.
  std::vector<BeamHit> hits(const Pose& T_map_sensor, const LidarModel& lidar) const;

  /// Distance [m] from `origin` along `direction` (of any length but 0) to the first surface; none when there
  /// is none.
  std::optional<double> range(const Eigen::Vector3d& origin, const Eigen::Vector3d& direction) const;

 private:
  RayCaster ray_caster_;
};

}  // namespace evermap
