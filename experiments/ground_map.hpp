// SPDX-FileCopyrightText: 2026 the evermap authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <optional>
#include <unordered_map>

#include <Eigen/Core>

#include <evermap/evaluation/map_metrics.hpp>

namespace evermap {

/// Where the ground is and what stands on it, in square cells seen from above.
class GroundMap {
 public:
  static constexpr double kCell = 0.5;  ///< [m]

  explicit GroundMap(const Points& surface);

  /// Height [m] of the lowest surface; none where nothing was seen.
  std::optional<double> height(const Eigen::Vector2d& xy) const;
  /// Whether a rectangle of half size `half` [m], turned by `yaw` [rad], is ground that was seen and on which
  /// nothing stands.
  bool is_free(const Eigen::Vector2d& center, double yaw, const Eigen::Vector2d& half) const;
  /// Number of points that stand in a square cell of `edge` [m] around `center`.
  std::size_t standing(const Eigen::Vector2d& center, double edge) const;

 private:
  struct Column {
    double lowest;             ///< [m]
    std::size_t standing = 0;  ///< points 0.4 to 2.2 m above it
  };
  static std::uint64_t key(const Eigen::Vector2d& xy);

  std::unordered_map<std::uint64_t, Column> columns_;
};

}  // namespace evermap
