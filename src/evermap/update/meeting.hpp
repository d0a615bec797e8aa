// SPDX-FileCopyrightText: 2026 the evermap authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include <evermap/map/ray_fan.hpp>
#include <evermap/scan/ray_bundle.hpp>
#include <evermap/update/parameters.hpp>

namespace evermap {

/// A bundle's ray that passes through a leaf.
struct Meeting {
  VoxelKey key;
  const Leaf* leaf;
  std::uint32_t bundle;  ///< index into BundleGrid::bundles()
  RayFan::Target target;
};

/// The bundles' rays, each up to where it is free for all that its range's noise may be.
std::vector<RayFan::Target> looked_at(const BundleGrid& bundles, const UpdateParameters& parameters);

/// Which leaves of these bricks the rays of `fan` meet, in the order of bricks. A leaf that the scan hit
/// takes no miss, so it is left out, unless its geometry may be trimmed all the same. The leaves, all over
/// the memory, are asked for already. REQUIRES: bricks ascend. Thread safe.
std::vector<Meeting> meet(const BundleGrid& bundles, const RayFan& fan, std::span<const PlacedBrick> bricks,
                          const UpdateParameters& parameters);

}  // namespace evermap
