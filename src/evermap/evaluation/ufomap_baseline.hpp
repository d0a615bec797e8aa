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

/// UFOMap, a faster relative of OctoMap. There only when CMake found ufomap. Not thread safe.
///
/// Its defaults: hit 0.7, miss 0.4, clamping at 0.1192 and 0.971, occupied above 0.5, depth 16, pruned
/// automatically. Scans go in as its own mapping server puts them in: insertPointCloudDiscrete, which casts
/// one ray per end voxel, with no limit of range, depth 0, exact ray casting and no early stopping. That call
/// uses a second thread of its own for the hits.
class UfoMapBaseline {
 public:
  explicit UfoMapBaseline(double edge);  ///< [m] of a leaf
  ~UfoMapBaseline();
  UfoMapBaseline(UfoMapBaseline&&) noexcept;
  UfoMapBaseline& operator=(UfoMapBaseline&&) noexcept;

  /// Marks the leaves of known surface occupied, as surely as the map can hold (the clamping maximum).
  void insert_surface(const Points& points_map);

  /// The integration of a scan, converted and ready to run. REQUIRES: the map still is when it runs.
  std::function<void()> prepare_scan(const Eigen::Vector3d& origin_map, const Points& points_map);

  bool occupied(const Eigen::Vector3d& p_map) const;
  Points occupied_centers() const;   ///< [m] of every occupied leaf of edge length `edge`
  std::size_t memory_bytes() const;  ///< by UFOMap's own account
  static std::string version();      ///< of the UFOMap that was compiled against

 private:
  struct Tree;
  std::unique_ptr<Tree> tree_;
};

}  // namespace evermap
