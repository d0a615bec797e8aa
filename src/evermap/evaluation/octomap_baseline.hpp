// SPDX-FileCopyrightText: 2026 the evermap authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstddef>
#include <functional>
#include <memory>
#include <string>

#include <Eigen/Core>

#include <evermap/evaluation/map_metrics.hpp>

namespace evermap {

/// OctoMap, the occupancy grid that maps are compared with. One thread: its optional OpenMP is not compiled
/// in. Not thread safe.
///
/// Its defaults: hit 0.7, miss 0.4, clamping at 0.1192 and 0.971, occupied above 0.5, depth 16. Scans go in
/// by insertPointCloud, which casts one ray per point.
class OctoMapBaseline {
 public:
  explicit OctoMapBaseline(double edge);  ///< [m] of a leaf
  ~OctoMapBaseline();
  OctoMapBaseline(OctoMapBaseline&&) noexcept;
  OctoMapBaseline& operator=(OctoMapBaseline&&) noexcept;

  /// Marks the leaves of known surface occupied, as surely as the map can hold (the clamping maximum).
  void insert_surface(const Points& points_map);

  /// Integrates a scan: leaves along the rays free, leaves of the ends occupied. Rays longer than `max_range`
  /// [m] are cut there and mark nothing occupied; a negative one means no limit.
  void insert_scan(const Eigen::Vector3d& origin_map, const Points& points_map, double max_range);

  /// The same, converted and ready to run. REQUIRES: the map still is when it runs.
  std::function<void()> prepare_scan(const Eigen::Vector3d& origin_map, const Points& points_map,
                                     double max_range = -1);

  bool occupied(const Eigen::Vector3d& p_map) const;
  Points occupied_centers() const;   ///< [m] of every occupied leaf of edge length `edge`
  std::size_t memory_bytes() const;  ///< by OctoMap's own account
  static std::string version();      ///< of the OctoMap that was compiled against

 private:
  struct Tree;
  std::unique_ptr<Tree> tree_;
};

}  // namespace evermap
