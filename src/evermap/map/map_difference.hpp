// SPDX-FileCopyrightText: 2026 the evermap authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstddef>
#include <vector>

#include <evermap/map/octree.hpp>

namespace evermap {

/// The occupied leaves whose surface the other map does not show, each list in ascending order.
///
/// A map shows a surface when its mean lies in the 99 % ellipsoid of one of the map's leaves in the same
/// voxel or one of the 26 around it, widened by kTolerance of the edge. So surface that noise carried across
/// a voxel's border, or that was sampled elsewhere in its plane, is no change.
struct MapDifference {
  static constexpr double kTolerance = 1.0 / 16;

  std::vector<VoxelKey> added;     ///< occupied after, not before
  std::vector<VoxelKey> removed;   ///< occupied before, not after
  std::vector<VoxelKey> moved;     ///< occupied in both; listed for the surface as it is after
  std::size_t border_added = 0;    ///< leaves occupied after, not before, whose surface both maps show
  std::size_t border_removed = 0;  ///< leaves occupied before, not after, whose surface both maps show
};

/// REQUIRES: both maps have the same grid.
MapDifference compare(const Octree& before, const Octree& after);

}  // namespace evermap
