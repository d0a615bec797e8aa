// SPDX-FileCopyrightText: 2026 the evermap authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <span>
#include <vector>

#include <Eigen/Core>
#include <Eigen/Geometry>

#include <evermap/geometry/ray.hpp>
#include <evermap/map/detail/voxel_walk.hpp>
#include <evermap/map/octree.hpp>

namespace evermap {

/// The rays of one scan, sorted by direction, so that each brick of the map finds the few rays that may cross
/// it, and no ray is walked through empty space.
///
///   rays     cell after cell: row by row, in a row by column
///   column   azimuth, as diamond angle in [-2, 2]: y / (|x| + |y|) where x > 0, mirrored behind
///   row      height, z / (|x| + |y| + |z|) in [-1, 1]
///
/// Both grow with the angle that they stand for, without trigonometry, so the corners of a box bound its
/// cells. Which leaves a ray meets is still decided by the exact VoxelWalk. Thread safe after construction.
class RayFan {
 public:
  struct Target {
    Eigen::Vector3d end_map;  ///< [m] where the ray ends
    double until;             ///< up to which share of the ray it is looked at, at most 1
  };

  /// Left out are rays without a length or a share to look at, and those with an end beyond the range of
  /// keys.
  RayFan(const VoxelGrid& grid, const Eigen::Vector3d& origin_map, std::span<const Target> targets);

  /// A box around all voxels that the rays pass through; empty when there is no ray.
  const Eigen::AlignedBox3i& voxels() const { return voxels_; }

  /// Visits each of these leaves of a brick that a ray meets: `visit(index, target, key, leaf)`. Rays come in
  /// a fixed order, the leaves of a ray front to back. REQUIRES: the brick has the leaves.
  template <class Visit>
  void for_each_met(const PlacedBrick& placed, const Mask512& leaves, Visit&& visit) const {
    if (leaves.empty()) return;
    const Eigen::AlignedBox3i bounds = leaves.bounds().translate(placed.corner);
    const Eigen::AlignedBox3d box(bounds.min().cast<double>() - origin_,
                                  (bounds.max().array() + 1).matrix().cast<double>() - origin_);
    const auto distance = static_cast<float>(box.exteriorDistance(Eigen::Vector3d(0, 0, 0)));
    for (const Cells& cells : cells_of(box)) {
      for (std::size_t row = cells.first_row; row < cells.last_row; ++row) {
        const std::size_t end = cell_begin_[row * kColumns + cells.last_column];
        for (std::size_t i = cell_begin_[row * kColumns + cells.first_column]; i < end; ++i) {
          if (reach_[i] < distance) continue;
          if (may_cross(rays_[i], box)) meet(rays_[i], placed, leaves, bounds, visit);
        }
      }
    }
  }

 private:
  static constexpr std::size_t kColumns = 512;
  static constexpr std::size_t kRows = 128;

  /// A VoxelRay of the common origin; one cache line.
  struct alignas(64) FanRay {
    Target target;
    Eigen::Vector3d inverse;
    std::uint32_t index;  ///< of the target
  };
  static constexpr std::uint32_t kNoCell = std::numeric_limits<std::uint32_t>::max();

  /// A rectangle of cells; the last ones are excluded.
  struct Cells {
    std::size_t first_row, last_row, first_column, last_column;
  };

  /// The cell of a direction; none of no direction.
  static std::uint32_t cell_of(const Eigen::Vector3d& direction);

  /// The cells of all directions in which a box lies, [voxels] from the origin: two rectangles when it lies
  /// across the seam behind the sensor.
  std::array<Cells, 2> cells_of(const Eigen::AlignedBox3d& box) const;

  /// Whether the looked-at share of a ray crosses a box, [voxels] from the origin. Computed as VoxelRay
  /// computes crossings, so that rounding never hides a leaf.
  static bool may_cross(const FanRay& ray, const Eigen::AlignedBox3d& box) {
    const Eigen::Array3d to_low = box.min().array() * ray.inverse.array();
    const Eigen::Array3d to_high = box.max().array() * ray.inverse.array();
    const double entry = to_low.min(to_high).maxCoeff();
    const double exit = to_low.max(to_high).minCoeff();
    return entry <= exit && exit >= 0 && entry <= ray.target.until;
  }

  template <class Visit>
  void meet(const FanRay& ray, const PlacedBrick& placed, const Mask512& leaves,
            const Eigen::AlignedBox3i& bounds, Visit&& visit) const {
    VoxelWalk walk({origin_, ray.inverse}, start_);
    if (!bounds.contains(start_)) {
      const VoxelWalk::Crossing entry = walk.entry_into(bounds);
      if (entry.time < 0) return;  // the ray begins on a face and moves away
      walk.leap(entry);
    }
    for (; walk.entry() <= ray.target.until && bounds.contains(walk.voxel()); walk.step()) {
      const Eigen::Vector3i& v = walk.voxel();
      const int index = (v.z() & 7) << 6 | (v.y() & 7) << 3 | (v.x() & 7);
      if (leaves.has(index)) visit(ray.index, ray.target, placed.key(index), *placed.brick->find(index));
    }
  }

  Eigen::Vector3d origin_;  ///< [voxels]
  Eigen::Vector3i start_;   ///< voxel of the origin
  Eigen::AlignedBox3i voxels_;
  std::vector<FanRay> rays_;
  std::vector<float> reach_;  ///< [voxels] how far each ray is looked at; half of all tests need no more
  std::vector<std::uint32_t> cell_begin_;  ///< index of each cell's first ray, and the number of rays
};

}  // namespace evermap
