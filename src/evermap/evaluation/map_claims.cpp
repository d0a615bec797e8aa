// SPDX-FileCopyrightText: 2026 the evermap authors
// SPDX-License-Identifier: BSD-3-Clause
#include <evermap/evaluation/map_claims.hpp>
#include <evermap/update/detail/impact.hpp>

namespace evermap {
namespace {

/// The leaf in whose ellipsoid the point lies, if any.
const Leaf* leaf_around(const Octree& octree, const Eigen::Vector3d& p_map, double position_sigma) {
  const auto key = octree.grid().key(p_map);
  const Leaf* leaf = key ? octree.find(*key) : nullptr;
  if (leaf == nullptr) return nullptr;
  const Gaussian known = octree.gaussian(*key, *leaf);
  Gaussian surface = predictive(known, plane_of(known), octree.grid().edge, UpdateParameters{}.extent_prior);
  surface.covariance += position_sigma * position_sigma * Eigen::Matrix3d::Identity();
  return mahalanobis_squared(p_map, surface) <= kChiSquared99 ? leaf : nullptr;
}

}  // namespace

bool claims(const Octree& octree, const Eigen::Vector3d& p_map, double position_sigma) {
  const Leaf* leaf = leaf_around(octree, p_map, position_sigma);
  return leaf != nullptr && leaf->occupied();
}

bool notices(const Octree& octree, const Eigen::Vector3d& p_map, double position_sigma) {
  return leaf_around(octree, p_map, position_sigma) != nullptr;
}

Points surface_points(const Octree& octree) {
  Points points;
  octree.for_each_leaf([&](VoxelKey key, const Leaf& leaf) {
    if (leaf.occupied()) points.push_back(octree.gaussian(key, leaf).mean);
  });
  return points;
}

}  // namespace evermap
