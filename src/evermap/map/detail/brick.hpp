// SPDX-FileCopyrightText: 2026 the evermap authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>

#include <Eigen/Core>

#include <evermap/geometry/voxel_key.hpp>
#include <evermap/map/detail/wide_node.hpp>
#include <evermap/map/leaf.hpp>

namespace evermap {

using Brick = WideNode<Leaf>;

/// A brick and where it is.
struct PlacedBrick {
  const Brick* brick;
  VoxelKey first;          ///< key of its lowest voxel
  Eigen::Vector3i corner;  ///< its lowest voxel

  VoxelKey key(int voxel_in_brick) const { return first.with_voxel(voxel_in_brick); }
};

}  // namespace evermap
