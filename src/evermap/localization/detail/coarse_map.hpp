// SPDX-FileCopyrightText: 2026 the evermap authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <vector>

#include <evermap/map/octree.hpp>

namespace evermap {

/// The map's occupied leaves around a place as ever coarser octrees, the finest first, each of twice the edge
/// of the one before; the first has twice the map's. They live for one registration and are kept nowhere.
std::vector<Octree> coarse_views(const Octree& map, const Eigen::Vector3d& center_map);

}  // namespace evermap
