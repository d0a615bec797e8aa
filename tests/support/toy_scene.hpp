// SPDX-FileCopyrightText: 2026 the evermap authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <algorithm>
#include <cmath>
#include <limits>
#include <support/random_geometry.hpp>
#include <vector>

#include <Eigen/Geometry>

#include <evermap/scan/scan.hpp>

namespace evermap::test {

/// Boxes on flat ground, seen by a sensor that looks around at random.
struct ToyScene {
  double ground = 0;  ///< [m] z of the ground
  std::vector<Eigen::AlignedBox3d> boxes;

  /// `count` points, in the sensor's frame, with `noise` [m] of range; directions that meet nothing are
  /// drawn again.
  Scan scan(const Pose& T_map_sensor, int count, double noise, Random& random) const {
    Scan result;
    while (static_cast<int>(result.p_sensor.size()) < count) {
      const double azimuth = random.uniform(-0.7, 0.7);
      const double elevation = random.uniform(-0.4, 0.1);
      const Eigen::Vector3d u(std::cos(elevation) * std::cos(azimuth),
                              std::cos(elevation) * std::sin(azimuth), std::sin(elevation));
      const double range = first_hit(T_map_sensor.translation, T_map_sensor.rotation * u);
      if (range < 25) result.p_sensor.emplace_back((range + noise * random.normal()) * u);
    }
    return result;
  }

  double first_hit(const Eigen::Vector3d& origin, const Eigen::Vector3d& u) const {
    double range = u.z() < 0 ? (ground - origin.z()) / u.z() : std::numeric_limits<double>::infinity();
    for (const Eigen::AlignedBox3d& box : boxes) {
      const Eigen::Vector3d to_min = (box.min() - origin).cwiseQuotient(u);
      const Eigen::Vector3d to_max = (box.max() - origin).cwiseQuotient(u);
      const double entry = to_min.cwiseMin(to_max).maxCoeff();
      const double exit = to_min.cwiseMax(to_max).minCoeff();
      if (entry > 0 && entry < exit) range = std::min(range, entry);
    }
    return range;
  }
};

}  // namespace evermap::test
