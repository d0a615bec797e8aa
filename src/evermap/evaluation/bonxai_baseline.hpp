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

/// Bonxai's ProbabilisticMap, a hash grid made for speed. There only when CMake found Bonxai. Not thread
/// safe.
///
/// Its defaults, which are OctoMap's: hit 0.7, miss 0.4, clamping at 0.12 and 0.97, occupied above 0.5. Scans
/// go in by insertPointCloud with no limit of range.
class BonxaiBaseline {
 public:
  explicit BonxaiBaseline(double edge);  ///< [m] of a leaf
  ~BonxaiBaseline();
  BonxaiBaseline(BonxaiBaseline&&) noexcept;
  BonxaiBaseline& operator=(BonxaiBaseline&&) noexcept;

  /// Marks the leaves of known surface occupied, as surely as the map can hold (the clamping maximum).
  void insert_surface(const Points& points_map);

  /// The integration of a scan, converted and ready to run. REQUIRES: the map still is when it runs.
  std::function<void()> prepare_scan(const Eigen::Vector3d& origin_map, const Points& points_map);

  bool occupied(const Eigen::Vector3d& p_map) const;
  Points occupied_centers() const;                    ///< [m] of every occupied leaf
  std::size_t memory_bytes() const;                   ///< by Bonxai's own account
  static std::string version() { return "unknown"; }  ///< its headers do not tell

 private:
  struct Map;
  double edge_;
  std::unique_ptr<Map> map_;
};

}  // namespace evermap
