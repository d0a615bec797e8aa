// SPDX-FileCopyrightText: 2026 the evermap authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstddef>
#include <cstdint>
#include <unordered_set>
#include <vector>

#include <evermap/map/octree.hpp>
#include <evermap/scan/detail/ray_bundle.hpp>
#include <evermap/update/detail/rollback.hpp>
#include <evermap/update/parameters.hpp>

namespace evermap {

/// Voxels whose surface went while a map was kept. Not thread safe.
class GoneLeaves {
 public:
  void add(VoxelKey key) { keys_.insert(key.bits()); }
  bool contains(VoxelKey key) const { return keys_.contains(key.bits()); }

 private:
  std::unordered_set<std::uint64_t> keys_;
};

/// A surface goes as a whole. Of what stood at the sensor's height, rays see that its sides went, but none
/// goes through its top. So a region of coherent surface that the scan does not show goes when its rim lies
/// beside leaves that went, and next to nothing that still stands holds it. Leaves before a surface say
/// nothing of it, as a box stands before ground and walls.
///
/// `went`: the occupied leaves that this scan's rays took, in ascending order; `gone` remembers them and what
/// goes with them, for the scans to come. Returns how many leaves went.
std::size_t remove_regions(Octree& octree, std::vector<VoxelKey> went, GoneLeaves& gone,
                           const BundleGrid& bundles, const UpdateParameters& parameters, Rollback* rollback);

}  // namespace evermap
