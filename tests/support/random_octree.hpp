// SPDX-FileCopyrightText: 2026 the evermap authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <random>

#include <Eigen/Core>

#include <evermap/map/octree.hpp>

namespace evermap {

/// A map of up to `leaves` leaves, some of them side by side and some far apart; most are occupied, the
/// others pending.
inline Octree random_octree(std::mt19937& generator, int leaves, const VoxelGrid& grid, int reach = 300) {
  std::uniform_int_distribution<int> index(-reach, reach - 1);
  std::uniform_int_distribution<int> step(-1, 1);
  std::uniform_real_distribution<float> unit(-0.5F, 0.5F);
  const auto edge = static_cast<float>(grid.edge);
  Octree octree(grid);
  Eigen::Vector3i voxel(0, 0, 0);
  for (int i = 0; i < leaves; ++i) {
    const bool jumps = i % 16 == 0;
    if (jumps) voxel = {index(generator), index(generator), index(generator)};
    voxel = (voxel + Eigen::Vector3i(step(generator), step(generator), step(generator)))
                .cwiseMin(reach - 1)
                .cwiseMax(-reach);
    Leaf& leaf = octree.find_or_insert(VoxelKey::from_voxel(voxel));
    for (float& x : leaf.mean_in_voxel) x = edge * unit(generator);
    for (float& x : leaf.covariance) x = edge * edge * unit(generator);
    leaf.count = 1 + 100 * (unit(generator) + 0.5F);
    leaf.log_odds = 3.5F * (unit(generator) + 0.3F);
  }
  return octree;
}

}  // namespace evermap
