// SPDX-FileCopyrightText: 2026 the evermap authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <evermap/geometry/gaussian.hpp>
#include <evermap/map/leaf.hpp>
#include <evermap/update/parameters.hpp>

namespace evermap {

/// Additive: the union N_V u N_R, and one step up in occupancy. A leaf of count 0 is new: it becomes the
/// bundle and stays pending until `confirmations` scans have hit it. `center_map` [m] is the voxel's centre.
/// `error`: of the scan's alignment [m], see alignment_error().
void confirm(Leaf& leaf, const Gaussian& bundle, const Eigen::Vector3d& center_map, double error,
             const UpdateParameters& parameters);

/// Subtractive: one step down in occupancy, scaled by the impact of all rays of the scan together, and as
/// much less trust in the leaf's geometry. Returns false when the leaf is to be deleted: occupied before and
/// no longer, or pending and below a first hit.
[[nodiscard]] bool contradict(Leaf& leaf, double impact, const UpdateParameters& parameters);

}  // namespace evermap
