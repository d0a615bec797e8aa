// SPDX-FileCopyrightText: 2026 the evermap authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <vector>

#include <Eigen/Core>

#include <evermap/simulation/scene.hpp>

namespace evermap {

/// What truly changed between two states of a world, as points of surfaces, [m] in the map frame.
///
/// Points of the earlier state that the later one hides inside its solids (the ground under a new box) are in
/// no list: no ray can tell anything about them. Nor are those between unchanged and changed.
struct ChangeTruth {
  std::vector<Eigen::Vector3d> now;        ///< the surface as it is now
  std::vector<Eigen::Vector3d> unchanged;  ///< of the earlier surface, what still is surface
  std::vector<Eigen::Vector3d> removed;    ///< of the earlier surface, what is free space now
  std::vector<Eigen::Vector3d> added;      ///< of `now`, what was free or hidden before
};

/// Compares two scenes on samples `spacing` [m] apart. Unchanged is what lies within 1 cm of a surface of the
/// other scene; removed or added what lies farther than `changed_distance` [m] from all that can be seen of
/// it (half a leaf suits a map that is to be scored).
ChangeTruth change_truth(const Scene& before, const Scene& now, double spacing, double changed_distance);

}  // namespace evermap
