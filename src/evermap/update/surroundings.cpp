// SPDX-FileCopyrightText: 2026 the evermap authors
// SPDX-License-Identifier: BSD-3-Clause
#include <cmath>

#include <evermap/geometry/detail/neighbourhood.hpp>
#include <evermap/map/detail/leaf_finder.hpp>
#include <evermap/update/detail/surroundings.hpp>

namespace evermap {
namespace {

/// Calls f(key, surface) for the occupied leaf of this voxel and for those around it.
template <class Function>
void for_each_surface_around(const Octree& octree, VoxelKey center, Function&& f) {
  LeafFinder leaves(octree);
  for_each_in_neighbourhood(center, [&](VoxelKey near) {
    const Leaf* leaf = leaves.find(near);
    if (leaf != nullptr && leaf->occupied()) f(near, octree.gaussian(near, *leaf));
  });
}

}  // namespace

Plane plane_around(const Octree& octree, VoxelKey key) {
  constexpr int kLeast = 4;  // leaves; fewer lie in a plane anyhow
  const Eigen::Vector3d center = octree.grid().center(key);
  int count = 0;
  Eigen::Vector3d sum = Eigen::Vector3d::Zero();  // each leaf counts as much as another
  Eigen::Matrix3d moments = Eigen::Matrix3d::Zero();
  for_each_surface_around(octree, key, [&](VoxelKey /*near*/, const Gaussian& surface) {
    const Eigen::Vector3d from_center = surface.mean - center;
    ++count;
    sum += from_center;
    moments += surface.covariance + from_center * from_center.transpose();
  });
  if (count < kLeast) return {};
  const Eigen::Vector3d mean = sum / count;
  return plane_of({mean, moments / count - mean * mean.transpose(), static_cast<double>(count)});
}

Plane plane_of_surface(const Octree& octree, VoxelKey key, const Gaussian& leaf) {
  const Plane own = plane_of(leaf);
  return own.flat ? own : plane_around(octree, key);
}

std::vector<PlacedPlane> corner_around(const Octree& octree, VoxelKey key, const Gaussian& leaf) {
  constexpr double kParallel = 0.7;  // cosine of 45 degrees
  std::vector<PlacedPlane> planes;
  bool is_corner = false;
  for_each_surface_around(octree, key, [&](VoxelKey near, const Gaussian& surface) {
    if (near == key) return;
    const Plane plane = plane_of(surface);
    const double apart = plane.normal.dot(leaf.mean - surface.mean);
    if (!plane.flat || std::abs(apart) > octree.grid().edge / 2) return;
    planes.push_back({plane, leaf.mean - apart * plane.normal});
    if (std::abs(plane.normal.dot(planes.front().plane.normal)) < kParallel) is_corner = true;
  });
  if (!is_corner) planes.clear();
  return planes;
}

bool stands_before(const Plane& plane, const Eigen::Vector3d& on_plane, const Eigen::Vector3d& p_map,
                   const Eigen::Vector3d& origin_map, double clearance) {
  if (!plane.flat) return true;
  const double sensor_side = plane.normal.dot(origin_map - on_plane);
  const double side = plane.normal.dot(p_map - on_plane);
  return (sensor_side > 0 ? side : -side) > clearance;
}

}  // namespace evermap
