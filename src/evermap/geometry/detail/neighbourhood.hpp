// SPDX-FileCopyrightText: 2026 the evermap authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <Eigen/Core>

#include <evermap/geometry/voxel_key.hpp>

namespace evermap {

/// Whether `holds(key)` is true of this voxel or of one of the 26 around it, as far as they have keys.
template <class Predicate>
bool any_in_neighbourhood(VoxelKey center, Predicate&& holds) {
  const Eigen::Vector3i voxel = center.voxel();
  for (int i = 0; i < 27; ++i) {
    const Eigen::Vector3i near = voxel + Eigen::Vector3i(i % 3 - 1, i / 3 % 3 - 1, i / 9 - 1);
    if (VoxelKey::in_range(near) && holds(VoxelKey::from_voxel(near))) return true;
  }
  return false;
}

/// Calls f(key) for this voxel and for the 26 around it, as far as they have keys.
template <class Function>
void for_each_in_neighbourhood(VoxelKey center, Function&& f) {
  any_in_neighbourhood(center, [&](VoxelKey near) {
    f(near);
    return false;
  });
}

}  // namespace evermap
