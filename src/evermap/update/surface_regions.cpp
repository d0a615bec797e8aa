// SPDX-FileCopyrightText: 2026 the evermap authors
// SPDX-License-Identifier: BSD-3-Clause
#include <algorithm>
#include <cmath>
#include <unordered_map>
#include <utility>

#include <evermap/geometry/detail/neighbourhood.hpp>
#include <evermap/map/detail/leaf_finder.hpp>
#include <evermap/update/detail/surface_regions.hpp>
#include <evermap/update/detail/surroundings.hpp>

namespace evermap {
namespace {

/// The surface in a voxel.
struct Surface {
  Gaussian leaf;
  Plane plane;
  int region = 0;  ///< that it belongs to, from 1 on
};

/// The regions of surface beside what went, as the map is now.
class SurfaceRegions {
 public:
  SurfaceRegions(const Octree& octree, const GoneLeaves& gone, const BundleGrid& bundles,
                 const UpdateParameters& parameters)
      : octree_(octree), leaves_(octree), gone_(gone), bundles_(bundles), parameters_(parameters) {}

  /// The leaves of the regions beside this leaf that go.
  std::vector<VoxelKey> going_with(VoxelKey went) {
    constexpr int kHole = 4;  // [voxels] a smaller hole is no rim
    int hole = 0;
    for_each_in_neighbourhood(went, [&](VoxelKey near) { hole += gone_.contains(near) ? 1 : 0; });
    std::vector<VoxelKey> going;
    if (hole < kHole) return going;
    for_each_in_neighbourhood(went, [&](VoxelKey key) {
      const Leaf* leaf = leaves_.find(key);
      if (leaf == nullptr || !leaf->occupied() || bundles_.find(key) != nullptr) return;
      const Surface& surface = at(key, *leaf);
      if (surface.region > 0 || !surface.plane.flat || is_before(surface, octree_.grid().center(went)))
        return;
      const std::vector<VoxelKey> region = detached_region(key, *leaf);
      going.insert(going.end(), region.begin(), region.end());
    });
    return going;
  }

 private:
  static constexpr std::size_t kLargest = 1000;  ///< [leaves] what is larger is ground or a building
  static constexpr int kMostHeld = 30;           ///< [leaves] a quarter of such a region's rim

  /// What is beside the leaves of a region.
  struct Rim {
    int leaves = 0;              ///< of the region that do not lie within it
    int lost = 0;                ///< leaves of the region beside voxels whose leaves went
    int held = 0;                ///< leaves of the region beside what still stands
    std::vector<VoxelKey> gone;  ///< those voxels, some more than once
  };

  /// REQUIRES: `leaf` is that of the voxel. The reference holds.
  Surface& at(VoxelKey key, const Leaf& leaf) {
    const auto found = surfaces_.find(key.bits());
    if (found != surfaces_.end()) return found->second;
    const Gaussian surface = octree_.gaussian(key, leaf);
    return surfaces_.emplace(key.bits(), Surface{surface, plane_of_surface(octree_, key, surface)})
        .first->second;
  }

  bool is_before(const Surface& surface, const Eigen::Vector3d& p_map) const {
    return stands_before(surface.plane, surface.leaf.mean, p_map, bundles_.origin_map,
                         octree_.grid().edge / 2);
  }

  /// Whether one surface goes on in the other.
  bool are_coherent(const Surface& a, const Surface& b) const {
    constexpr double kCosine = 0.85;  // of 30 degrees
    if (!b.plane.flat || std::abs(a.plane.normal.dot(b.plane.normal)) < kCosine) return false;
    const Eigen::Vector3d apart = b.leaf.mean - a.leaf.mean;
    const double step = octree_.grid().edge / 2;
    return std::abs(a.plane.normal.dot(apart)) <= step && std::abs(b.plane.normal.dot(apart)) <= step;
  }

  /// Whether what still stands holds a surface beside it, and does not merely lie behind.
  bool holds(const Surface& other, const Surface& surface) const {
    return !other.plane.flat || !is_before(other, surface.leaf.mean);
  }

  /// Adds what is beside this leaf to `rim`, and the neighbours that are coherent with it and in no region to
  /// `region`. Returns false when one of them is in another region: that one was left before its end.
  bool look_around(VoxelKey key, std::vector<VoxelKey>& region, Rim& rim) {
    constexpr int kWithin = 7;  // neighbours that a leaf has within a surface, at the least
    const Surface surface = at(key, *leaves_.find(key));
    int within = 0;
    bool is_lost = false, is_held = false, meets_another = false;
    for_each_in_neighbourhood(key, [&](VoxelKey near) {
      if (near == key) return;
      const Leaf* leaf = leaves_.find(near);
      if (leaf == nullptr || !leaf->occupied()) {
        if (!gone_.contains(near) || is_before(surface, octree_.grid().center(near))) return;
        is_lost = true;
        rim.gone.push_back(near);
        return;
      }
      if (bundles_.find(near) != nullptr) {  // another surface, or more of this one
        const Gaussian hit = octree_.gaussian(near, *leaf);
        is_held = is_held || holds({hit, plane_of(hit)}, surface);
        return;
      }
      Surface& neighbour = at(near, *leaf);
      if (are_coherent(surface, neighbour)) {
        ++within;
        meets_another = meets_another || (neighbour.region > 0 && neighbour.region != surface.region);
        if (neighbour.region > 0) return;
        neighbour.region = surface.region;
        region.push_back(near);
      } else if (leaf->log_odds > static_cast<float>(parameters_.max_log_odds)) {
        is_held = is_held || holds(neighbour, surface);
      }
    });
    rim.leaves += within < kWithin ? 1 : 0;
    rim.lost += is_lost ? 1 : 0;
    rim.held += is_held ? 1 : 0;
    return !meets_another;
  }

  /// All that is coherent with this leaf, from neighbour to neighbour, if it is detached; else nothing.
  std::vector<VoxelKey> detached_region(VoxelKey start, const Leaf& leaf) {
    std::vector<VoxelKey> region{start};
    at(start, leaf).region = ++regions_;
    Rim rim;
    for (std::size_t i = 0; i < region.size(); ++i) {
      const bool is_whole = look_around(region[i], region, rim);
      if (!is_whole || region.size() > kLargest || rim.held > kMostHeld) return {};
    }
    if (!is_detached(rim)) region.clear();
    return region;
  }

  bool is_detached(Rim& rim) const {
    constexpr std::ptrdiff_t kLeastGone = 4;  // voxels; fewer may be a mistake
    constexpr double kHeld = 0.25;            // of the leaves beside what went
    if (rim.lost < parameters_.rim_gone * rim.leaves || rim.held > kHeld * rim.lost) return false;
    std::sort(rim.gone.begin(), rim.gone.end());
    return std::unique(rim.gone.begin(), rim.gone.end()) - rim.gone.begin() >= kLeastGone;
  }

  const Octree& octree_;
  LeafFinder<const Octree> leaves_;
  const GoneLeaves& gone_;
  const BundleGrid& bundles_;
  const UpdateParameters& parameters_;
  std::unordered_map<std::uint64_t, Surface> surfaces_;
  int regions_ = 0;
};

}  // namespace

std::size_t remove_regions(Octree& octree, std::vector<VoxelKey> went, GoneLeaves& gone,
                           const BundleGrid& bundles, const UpdateParameters& parameters,
                           Rollback* rollback) {
  std::size_t count = 0;
  while (!went.empty()) {  // what goes may leave other surface detached
    for (const VoxelKey key : went) gone.add(key);
    SurfaceRegions regions(octree, gone, bundles, parameters);
    std::vector<VoxelKey> going;
    for (const VoxelKey key : went) {
      const std::vector<VoxelKey> with_it = regions.going_with(key);
      going.insert(going.end(), with_it.begin(), with_it.end());
    }
    for (const VoxelKey key : going) {
      if (rollback != nullptr) rollback->remember(key, std::as_const(octree).find(key));
      octree.erase(key);
    }
    count += going.size();
    went = std::move(going);
  }
  return count;
}

}  // namespace evermap
