// SPDX-FileCopyrightText: 2026 the evermap authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <span>
#include <vector>

#include <evermap/map/octree.hpp>

namespace evermap {

/// A leaf as it is after a change. One of no points (count 0) went.
struct LeafChange {
  VoxelKey key;
  Leaf leaf;

  bool is_removed() const { return leaf.count == 0; }
};

/// What makes `before` to `after`, in ascending order of keys. What two snapshots of one map still share is
/// not looked at. REQUIRES: both maps have the same grid.
std::vector<LeafChange> changes_between(const Octree& before, const Octree& after);

void apply_changes(std::span<const LeafChange> changes, Octree& octree);

}  // namespace evermap
