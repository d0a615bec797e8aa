// SPDX-FileCopyrightText: 2026 the evermap authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <support/random_geometry.hpp>
#include <vector>

#include <evermap/geometry/ray.hpp>
#include <evermap/map/octree.hpp>

namespace evermap::test {

inline Octree octree_of(const VoxelGrid& grid, const std::vector<Eigen::Vector3i>& voxels,
                        const Eigen::Vector3i& place = {0, 0, 0}) {
  Octree octree(grid);
  for (const Eigen::Vector3i& voxel : voxels)
    octree.find_or_insert(VoxelKey::from_voxel(place + voxel)).log_odds = 1;
  return octree;
}

/// A sparse scene: dense clusters, a sheet of ground and stray leaves, so that rays
/// leap over blocks, leap over bricks and step through full bricks.
inline std::vector<Eigen::Vector3i> random_scene(Random& random) {
  std::vector<Eigen::Vector3i> voxels;
  for (int cluster = 0; cluster < 8; ++cluster) {
    const Eigen::Vector3i corner(random.integer(-70, 70), random.integer(-70, 70), random.integer(-70, 70));
    const Eigen::Vector3i size(random.integer(1, 12), random.integer(1, 12), random.integer(1, 12));
    const double fill = random.uniform(0.1, 1);
    for (int i = 0; i < size.prod(); ++i) {
      const Eigen::Vector3i inside(i % size.x(), i / size.x() % size.y(), i / size.x() / size.y());
      if (random.chance(fill)) voxels.emplace_back(corner + inside);
    }
  }
  for (int i = 0; i < 2000; ++i) voxels.emplace_back(random.integer(-64, 64), random.integer(-64, 64), -3);
  for (int i = 0; i < 300; ++i) {
    voxels.emplace_back(random.integer(-99, 99), random.integer(-99, 99), random.integer(-99, 99));
  }
  return voxels;
}

/// Rays of every kind that a walk may stumble over, in voxels relative to the scene's middle. Half of their
/// ends lie at leaves.
struct RayMaker {
  Random& random;
  std::vector<Eigen::Vector3i> leaves;  ///< relative to the scene's middle

  Eigen::Vector3d at_leaf() {
    return leaves[static_cast<std::size_t>(random.integer(0, static_cast<int>(leaves.size()) - 1))]
        .cast<double>();
  }
  Eigen::Vector3d anywhere() {
    return random.chance(0.5) ? random.in_cube(90)
                              : at_leaf() + 0.5 * Eigen::Vector3d::Ones() + random.in_cube(0.5);
  }
  Eigen::Vector3d corner() {
    return random.chance(0.5) ? random.in_cube(90).array().round().matrix() : at_leaf();
  }
  Eigen::Vector3d signs() {
    return {random.chance(0.5) ? 1.0 : -1.0, random.chance(0.5) ? 1.0 : -1.0,
            random.chance(0.5) ? 1.0 : -1.0};
  }
  Eigen::Vector3d along_axis() {
    return random.uniform(-99, 99) * Eigen::Vector3d::Unit(random.integer(0, 2));
  }

  static constexpr int kKinds = 14;
  Ray make(int kind) {
    const Eigen::Vector3d from = anywhere(), lattice = corner();
    switch (kind) {
      case 0:
        return {from, from + along_axis()};
      case 1:
        return {lattice, lattice + along_axis()};  // along an edge shared by four voxels
      case 2:
        return {lattice, corner()};  // from corner to corner
      case 3:
        return {lattice, lattice + random.uniform(1, 80) * signs()};  // corner after corner
      case 4:
        return {from, from + random.uniform(1, 80) * signs()};
      case 5:
        return {lattice, anywhere()};
      case 6:
        return {from, lattice};
      case 7:
        return {random.uniform(1.5, 3) * 90 * random.direction(), from};  // from outside the scene
      case 8:
        return {random.uniform(1.5, 3) * 90 * random.direction(), 2 * anywhere()};
      case 9:
        return {at_leaf() + 0.5 * Eigen::Vector3d::Ones() + random.in_cube(0.49), from};
      case 10:
        return {from, from};  // no length
      case 11:
        return within_a_plane(lattice, from);
      case 12:
        return nearly_parallel(from);
      default:
        return {from, anywhere()};
    }
  }

  /// In the boundary between two layers of voxels.
  Ray within_a_plane(Eigen::Vector3d origin, Eigen::Vector3d end) {
    const int axis = random.integer(0, 2);
    end[axis] = origin[axis];
    return {origin, end};
  }
  /// Components that cannot be told from 0, seen from any other coordinate than 0.
  Ray nearly_parallel(Eigen::Vector3d origin) {
    const int axis = random.integer(0, 2);
    Eigen::Vector3d end = origin + random.uniform(-99, 99) * Eigen::Vector3d::Unit(axis);
    for (const int other : {(axis + 1) % 3, (axis + 2) % 3}) {
      origin[other] = random.chance(0.5) ? 0 : origin[other];
      end[other] = origin[other] + (random.chance(0.5) ? 1 : -1) * random.log_uniform(1e-307, 1e-6);
      if (random.chance(0.3)) end[other] = random.chance(0.5) ? 1e-300 : -1e-300;
    }
    return {origin, end};
  }
};

}  // namespace evermap::test
