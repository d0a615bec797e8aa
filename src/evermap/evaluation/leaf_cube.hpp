// SPDX-FileCopyrightText: 2026 the evermap authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <Eigen/Core>

#include <evermap/evaluation/map_metrics.hpp>

namespace evermap {

/// Appends the centres [m] of all leaves in a cube of per_edge^3 equal ones, which occupancy grids prune to
/// one node. `middle` [m] is the cube's, `edge` [m] a leaf's.
inline void add_leaf_centers(const Eigen::Vector3d& middle, double edge, int per_edge, Points& centers) {
  const Eigen::Vector3d first = middle.array() - 0.5 * edge * (per_edge - 1);
  for (int z = 0; z < per_edge; ++z) {
    for (int y = 0; y < per_edge; ++y) {
      for (int x = 0; x < per_edge; ++x) centers.emplace_back(first + edge * Eigen::Vector3d(x, y, z));
    }
  }
}

}  // namespace evermap
