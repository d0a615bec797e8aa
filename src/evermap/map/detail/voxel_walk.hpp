// SPDX-FileCopyrightText: 2026 the evermap authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <algorithm>
#include <cmath>
#include <limits>

#include <Eigen/Core>
#include <Eigen/Geometry>

#include <evermap/geometry/ray.hpp>
#include <evermap/geometry/voxel_key.hpp>

namespace evermap {

/// A ray in units of voxels, prepared to tell when it crosses which boundary.
struct VoxelRay {
  Eigen::Vector3d origin;   ///< [voxels]
  Eigen::Vector3d inverse;  ///< 1 / length along each axis [1 / voxels], finite: 0 * inverse is 0

  static VoxelRay of(const VoxelGrid& grid, const Ray& ray) {
    return towards((ray.origin - grid.origin) / grid.edge, (ray.end - ray.origin) / grid.edge);
  }
  static VoxelRay towards(const Eigen::Vector3d& origin, const Eigen::Vector3d& direction) {
    // An axis along which the ray stands still counts as ascending, and is crossed after all time.
    constexpr double kHuge = std::numeric_limits<double>::max();
    const Eigen::Vector3d inverse = direction.cwiseInverse().cwiseMin(kHuge).cwiseMax(-kHuge);
    return {origin, (direction.array() == 0).select(kHuge, inverse)};
  }

  bool ascends(int axis) const { return inverse[axis] > 0; }
  /// When the ray crosses a boundary, as a share of its length.
  double crossing(int axis, int boundary) const { return (boundary - origin[axis]) * inverse[axis]; }
};

/// Walks the voxels of a grid that a ray passes through, exactly, and can leap to where it enters or leaves
/// an aligned box of voxels.
///
/// Every boundary crossing is computed afresh from the integer index of the boundary, never accumulated, and
/// ties at edges and corners go to the lower axis. So a leap ends in the very voxel, at the very time, that
/// single steps would have reached. (After Amanatides & Woo, "A fast voxel traversal algorithm for ray
/// tracing", 1987.)
class VoxelWalk {
 public:
  /// REQUIRES: `start` is the voxel of the ray's origin.
  VoxelWalk(const VoxelRay& ray, const Eigen::Vector3i& start) : ray_(ray), voxel_(start) {
    for (int axis = 0; axis < 3; ++axis) {
      ahead_[axis] = ray_.ascends(axis) ? 1 : 0;
      look_ahead(axis);
    }
  }

  const Eigen::Vector3i& voxel() const { return voxel_; }
  double entry() const { return entry_; }      ///< of the voxel, as a share of the ray's length
  bool inside() const { return entry_ <= 1; }  ///< false once the ray has ended
  double exit() const { return std::min(std::min(next_[0], next_[1]), next_[2]); }  ///< of the voxel

  /// The crossing of one boundary.
  struct Crossing {
    double time;   ///< as a share of the ray's length
    int axis;      ///< through whose boundary
    int boundary;  ///< [voxels]
  };

  /// Where the ray leaves the aligned cube of 2^level voxels a side that holds the current voxel.
  Crossing exit(int level) const {
    Crossing first{std::numeric_limits<double>::infinity(), 0, 0};
    for (int axis = 0; axis < 3; ++axis) {
      const int boundary = ((voxel_[axis] >> level) + ahead_[axis]) * (1 << level);
      const double time = ray_.crossing(axis, boundary);
      if (time < first.time) first = {time, axis, boundary};
    }
    return first;
  }

  /// Where the ray, now outside, enters a box of voxels. REQUIRES: it does, or passes at an edge.
  Crossing entry_into(const Eigen::AlignedBox3i& box) const {
    Crossing last{-std::numeric_limits<double>::infinity(), 0, 0};
    for (int axis = 0; axis < 3; ++axis) {
      if (voxel_[axis] >= box.min()[axis] && voxel_[axis] <= box.max()[axis]) continue;
      const int boundary = ray_.ascends(axis) ? box.min()[axis] : box.max()[axis] + 1;
      const double time = ray_.crossing(axis, boundary);
      if (time >= last.time) last = {time, axis, boundary};
    }
    return last;
  }

  /// Moves to the next voxel.
  void step() {
    const int first = first_axis();
    entry_ = exit();
    // Nothing foretells which axis it is: to do the same for all is faster than to choose one.
    for (int axis = 0; axis < 3; ++axis) {
      voxel_[axis] += axis == first ? 2 * ahead_[axis] - 1 : 0;
      look_ahead(axis);
    }
  }

  /// Moves to the first voxel beyond a crossing ahead. REQUIRES: the ray makes this crossing.
  void leap(const Crossing& crossing) {
    entry_ = crossing.time;
    if (!inside()) return;
    for (int axis = 0; axis < 3; ++axis) {
      voxel_[axis] = axis != crossing.axis ? index_at(axis, crossing) : crossing.boundary - 1 + ahead_[axis];
      look_ahead(axis);
    }
  }

 private:
  void look_ahead(int axis) { next_[axis] = ray_.crossing(axis, voxel_[axis] + ahead_[axis]); }

  /// The axis along which the ray leaves the voxel.
  int first_axis() const {
    const int lower = next_[1] < next_[0] ? 1 : 0;
    return next_[2] < std::min(next_[0], next_[1]) ? 2 : lower;
  }

  /// The voxel index along `axis` when the ray makes a crossing: a guess, corrected by exact crossings.
  int index_at(int axis, const Crossing& at) const {
    const auto crossed = [&](int boundary) {
      const double time = ray_.crossing(axis, boundary);
      return time < at.time || (time == at.time && axis < at.axis);
    };
    const int now = voxel_[axis];
    const auto guess = static_cast<int>(std::floor(ray_.origin[axis] + at.time / ray_.inverse[axis]));
    if (ray_.ascends(axis)) {
      int index = std::max(now, guess);
      while (index > now && !crossed(index)) --index;
      while (crossed(index + 1)) ++index;
      return index;
    }
    int index = std::min(now, guess);
    while (index < now && !crossed(index + 1)) ++index;
    while (crossed(index)) --index;
    return index;
  }

  VoxelRay ray_;
  Eigen::Vector3i voxel_;
  Eigen::Vector3i ahead_;  ///< 0 or 1: which of a voxel's two boundaries the ray crosses, along each axis
  double entry_ = 0;
  Eigen::Vector3d next_;  ///< when it does
};

}  // namespace evermap
