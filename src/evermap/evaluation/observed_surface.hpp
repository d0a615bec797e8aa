// SPDX-FileCopyrightText: 2026 the evermap authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <unordered_map>
#include <unordered_set>
#include <vector>

#include <evermap/evaluation/map_metrics.hpp>
#include <evermap/geometry/voxel_key.hpp>

namespace evermap {

/// Which points of a surface a run has observed: those within `reach` of the end of a ray. Of the ends in one
/// cube of edge reach/5, the first one counts.
///
/// Memory is bounded by the surface, however long the run: an end is forgotten once it is known which points
/// it observed, and a cube that has had its end is remembered only near points not yet observed. Not thread
/// safe.
class ObservedSurface {
 public:
  explicit ObservedSurface(double reach) : reach_(reach), cubes_{reach / 5}, cells_{5 * reach} {}

  /// Adds points [m, map frame] and gives the index of each; a point of an earlier surface has that one's.
  /// Points without a key in a grid of edge 5 reach are never observed. REQUIRES: no ends were added yet.
  std::vector<std::uint32_t> add_surface(const Points& points);
  /// Takes the ends [m, map frame] of rays, in the order in which they were measured.
  void add_ends(const Points& ends);

  const Eigen::Vector3d& point(std::uint32_t index) const { return points_[index]; }
  bool is_observed(std::uint32_t index) const { return is_observed_[index]; }

  std::size_t memory_bytes() const;

 private:
  /// The points in one voxel of `cells_`.
  struct Cell {
    std::vector<std::uint32_t> points;  ///< in lexicographic order of their coordinates
    std::size_t open = 0;               ///< points not observed
  };

  /// The index of a point that an earlier surface had in this cell.
  std::optional<std::uint32_t> find(const Cell& cell, const Eigen::Vector3d& p_map) const;
  /// Marks what an end observes in one cell. True when another end, no further than `diagonal` [m] from this
  /// one, could observe more there.
  bool mark(Cell& cell, const Eigen::Vector3d& end, double diagonal);

  double reach_;  ///< [m]
  VoxelGrid cubes_;
  VoxelGrid cells_;
  Points points_;  ///< of all surfaces
  std::vector<bool> is_observed_;
  std::unordered_map<std::uint64_t, Cell> cell_of_;
  std::unordered_set<std::uint64_t> taken_cubes_;  ///< that have had their end, near open points
};

}  // namespace evermap
