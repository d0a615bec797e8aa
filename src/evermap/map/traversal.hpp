// SPDX-FileCopyrightText: 2026 the evermap authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <limits>

#include <Eigen/Core>

#include <evermap/geometry/ray.hpp>
#include <evermap/map/octree.hpp>

namespace evermap {

/// Walks the voxels of a grid that a ray passes through, exactly, and can leap out of aligned cubes of
/// voxels.
///
/// Every boundary crossing is computed afresh from the integer index of the boundary, never accumulated, and
/// ties at edges and corners go to the lower axis. So a leap ends in the very voxel, at the very time, that
/// single steps would have reached. (After Amanatides & Woo, "A fast voxel traversal algorithm for ray
/// tracing", 1987.)
class VoxelWalk {
 public:
  /// REQUIRES: `start` is the voxel of the ray's origin in `grid`.
  VoxelWalk(const VoxelGrid& grid, const Ray& ray, const Eigen::Vector3i& start)
      : voxel_(start),
        origin_((ray.origin - grid.origin) / grid.edge),
        direction_((ray.end - ray.origin) / grid.edge),
        inverse_direction_(direction_.cwiseInverse()) {}

  const Eigen::Vector3i& voxel() const { return voxel_; }
  double entry() const { return entry_; }      ///< of the voxel, as a share of the ray's length
  bool inside() const { return entry_ <= 1; }  ///< false once the ray has ended

  /// Where the ray leaves the aligned cube of 2^level voxels a side that holds the current voxel.
  struct Exit {
    double time;   ///< as a share of the ray's length
    int axis;      ///< through whose boundary
    int boundary;  ///< [voxels]
  };
  Exit exit(int level) const {
    Exit first{std::numeric_limits<double>::max(), 0, 0};  // a ray without length stays where it is
    for (int axis = 0; axis < 3; ++axis) {
      const int cube = voxel_[axis] >> level;
      const int boundary = (direction_[axis] > 0 ? cube + 1 : cube) * (1 << level);
      const double time = crossing(axis, boundary);
      if (time < first.time) first = {time, axis, boundary};
    }
    return first;
  }

  /// Moves to the first voxel beyond a single voxel, given its exit(0).
  void step(const Exit& exit) {
    entry_ = exit.time;
    if (inside()) voxel_[exit.axis] = direction_[exit.axis] > 0 ? exit.boundary : exit.boundary - 1;
  }

  /// Moves to the first voxel beyond a larger cube, given its exit(level).
  void leap(const Exit& exit) {
    if (exit.time <= 1) {
      for (int axis = 0; axis < 3; ++axis) {
        if (axis != exit.axis && !std::isinf(inverse_direction_[axis])) voxel_[axis] = index_at(axis, exit);
      }
    }
    step(exit);
  }

 private:
  double crossing(int axis, int boundary) const {
    if (std::isinf(inverse_direction_[axis])) return std::numeric_limits<double>::infinity();
    return (boundary - origin_[axis]) * inverse_direction_[axis];
  }

  /// The voxel index along `axis` when the ray goes through `exit`: a guess, corrected by exact crossings.
  int index_at(int axis, const Exit& exit) const {
    const auto crossed = [&](int boundary) {
      const double time = crossing(axis, boundary);
      return time < exit.time || (time == exit.time && axis < exit.axis);
    };
    const int now = voxel_[axis];
    const auto guess = static_cast<int>(std::floor(origin_[axis] + direction_[axis] * exit.time));
    int index = direction_[axis] > 0 ? std::max(now, guess) : std::min(now, guess);
    if (direction_[axis] > 0) {
      while (index > now && !crossed(index)) --index;
      while (crossed(index + 1)) ++index;
    } else {
      while (index < now && !crossed(index + 1)) ++index;
      while (crossed(index)) --index;
    }
    return index;
  }

  Eigen::Vector3i voxel_;
  double entry_ = 0;
  Eigen::Vector3d origin_;     ///< [voxels]
  Eigen::Vector3d direction_;  ///< [voxels] the whole ray
  Eigen::Vector3d inverse_direction_;
};

/// Visits every leaf along a ray, pending ones too, front to back: `visit(key, leaf, entry, exit)`, the
/// distances from the ray's origin in metres; the last exit may lie beyond the ray's end. Visits nothing when
/// an end of the ray is beyond the range of keys. Const on the map: any number of threads may traverse it at
/// once.
template <class Visit>
void traverse(const Octree& octree, const Ray& ray, Visit&& visit) {
  constexpr int kBlockLevel = 6;
  constexpr int kBrickLevel = 3;
  const auto start = octree.grid().voxel(ray.origin);
  if (!start || !octree.grid().voxel(ray.end)) return;
  const double length = ray.length();
  VoxelWalk walk(octree.grid(), ray, *start);
  // A ray that ends on the border of the range of keys may step across it.
  const auto on_grid = [&walk] { return walk.inside() && VoxelKey::in_range(walk.voxel()); };
  while (on_grid()) {
    VoxelKey key = VoxelKey::from_voxel(walk.voxel());
    const std::uint64_t block_key = key.block();
    const Octree::Block* block = octree.find_block(block_key);
    if (block == nullptr) {
      walk.leap(walk.exit(kBlockLevel));
      continue;
    }
    for (; on_grid() && key.block() == block_key; key = VoxelKey::from_voxel(walk.voxel())) {
      const Octree::Brick* brick = block->find(key.brick_in_block());
      if (brick == nullptr) {
        walk.leap(walk.exit(kBrickLevel));
        continue;
      }
      const auto exit = walk.exit(0);
      const Leaf* leaf = brick->find(key.voxel_in_brick());
      if (leaf != nullptr) visit(key, *leaf, walk.entry() * length, exit.time * length);
      walk.step(exit);
    }
  }
}

/// As `traverse`, but the occupied leaves only.
template <class Visit>
void for_each_occupied(const Octree& octree, const Ray& ray, Visit&& visit) {
  traverse(octree, ray, [&](VoxelKey key, const Leaf& leaf, double entry, double exit) {
    if (leaf.occupied()) visit(key, leaf, entry, exit);
  });
}

}  // namespace evermap
