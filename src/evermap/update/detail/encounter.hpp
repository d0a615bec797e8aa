// SPDX-FileCopyrightText: 2026 the evermap authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include <evermap/map/detail/ray_fan.hpp>
#include <evermap/scan/detail/ray_bundle.hpp>
#include <evermap/update/parameters.hpp>

namespace evermap {

/// A bundle's ray passes through a leaf.
struct Encounter {
  VoxelKey key;
  const Leaf* leaf;
  std::uint32_t bundle;  ///< index into BundleGrid::bundles()
  RayFan::Target target;
};

/// The bundles' rays, each up to where the noise of its range forbids a verdict.
std::vector<RayFan::Target> looked_at(const BundleGrid& bundles);

/// Which leaves of these bricks the rays of `fan` pass through, in the order of bricks. A leaf that the scan
/// hit takes no miss, so it is left out; with trim_leaves it is kept, since its geometry may be trimmed. The
/// leaves are prefetched. REQUIRES: bricks ascend. Thread safe.
std::vector<Encounter> find_encounters(const BundleGrid& bundles, const RayFan& fan,
                                       std::span<const PlacedBrick> bricks,
                                       const UpdateParameters& parameters);

}  // namespace evermap
