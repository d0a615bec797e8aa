// SPDX-FileCopyrightText: 2026 the evermap authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <vector>

#include <Eigen/Core>
#include <Eigen/Geometry>

#include <evermap/simulation/scene.hpp>

namespace evermap {

/// Answers where a point lies relative to the solids of a scene, in double precision: how near to a surface,
/// and whether inside.
///
/// The triangles are sorted into square bins of the x-y plane. REQUIRES: the scene outlives the index and
/// does not change. Thread safe.
class SurfaceIndex {
 public:
  explicit SurfaceIndex(const Scene& scene);
  explicit SurfaceIndex(const Scene&&) = delete;  // the index would outlive it

  /// True when the point is inside a solid or on its surface, `except` not regarded. Points on the surface of
  /// a solid should name it there, since rounding puts them inside as often as outside. Side by side, solids
  /// should overlap: where two upright faces touch, either may be reported as open.
  bool buried(const Eigen::Vector3d& p_map, std::optional<int> except = std::nullopt) const;

  /// Distance [m] to the nearest surface; infinity when it is farther than `limit` [m].
  double distance(const Eigen::Vector3d& p_map, double limit) const;

 private:
  using Bin = Eigen::Vector2i;

  Bin bin(const Eigen::Vector2d& p) const;
  std::size_t slot(const Bin& bin) const;  ///< of a bin's list in `triangles_`

  const Scene* scene_;
  Eigen::AlignedBox2d bounds_;
  double bin_edge_ = 1;  ///< [m]
  Bin bins_ = Bin::Zero();
  std::vector<std::vector<std::uint32_t>> triangles_;  ///< by bin, row after row
};

}  // namespace evermap
