// SPDX-FileCopyrightText: 2026 the evermap authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <algorithm>
#include <array>
#include <cmath>

#include <Eigen/Core>

#include <evermap/geometry/gaussian.hpp>

namespace evermap {

/// What the map knows of one voxel: the surface in it as a Gaussian, and how sure it is that it is there.
///
/// Stored as float relative to the voxel's centre, so that precision does not fade far from the map's origin.
/// A leaf is *occupied* when its log-odds are positive. A leaf that exists but is not occupied is *pending*:
/// it was seen and waits for a second scan to confirm it.
struct Leaf {
  Eigen::Vector3f mean_in_voxel = Eigen::Vector3f::Zero();  ///< [m] from the voxel's centre
  std::array<float, 6> covariance{};                        ///< [m^2] xx xy xz yy yz zz
  float count = 0;                                          ///< points, capped so that the leaf can forget
  float log_odds = 0;                                       ///< of occupancy

  bool occupied() const { return log_odds > 0; }

  /// Whether every value is a number.
  bool is_finite() const {
    return mean_in_voxel.allFinite() && std::isfinite(count) && std::isfinite(log_odds) &&
           std::all_of(covariance.begin(), covariance.end(), [](float x) { return std::isfinite(x); });
  }

  /// Asks the memory for a leaf that is soon used: most lie across two cache lines.
  void prefetch() const {
    __builtin_prefetch(&mean_in_voxel);
    __builtin_prefetch(&log_odds);
  }

  Eigen::Matrix3d covariance_matrix() const {
    Eigen::Matrix3d S;
    S << covariance[0], covariance[1], covariance[2],  //
        covariance[1], covariance[3], covariance[4],   //
        covariance[2], covariance[4], covariance[5];
    return S;
  }

  /// The leaf's surface in the map frame, given its voxel's centre [m].
  Gaussian gaussian(const Eigen::Vector3d& center_map) const {
    return {center_map + mean_in_voxel.cast<double>(), covariance_matrix(), count};
  }

  void set_gaussian(const Gaussian& surface, const Eigen::Vector3d& center_map) {
    mean_in_voxel = (surface.mean - center_map).cast<float>();
    const auto& S = surface.covariance;
    const Eigen::Matrix<double, 6, 1> upper(S(0, 0), S(0, 1), S(0, 2), S(1, 1), S(1, 2), S(2, 2));
    Eigen::Map<Eigen::Matrix<float, 6, 1>>(covariance.data()) = upper.cast<float>();
    count = static_cast<float>(surface.count);
  }
};

}  // namespace evermap
