// SPDX-FileCopyrightText: 2026 the evermap authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <evermap/geometry/pose.hpp>

namespace evermap {

/// Remembers from where the world was last looked at, because a second look from one place adds little.
///
/// A sensor that stands still hits the same lines again and again. Merged at full weight, they would soon
/// outweigh all else that a leaf knows and shrink it to those lines.
class Viewpoint {
 public:
  /// Two looks are from one place when less than `radius` [m] and one degree apart.
  explicit Viewpoint(double radius) : radius_(radius) {}

  /// Takes the next scan's pose; returns the weight of its geometry: 1 from a new place, 1/k for the k-th
  /// look.
  double view_weight(const Pose& T_map_sensor) {
    const Pose apart = T_place_.inverse() * T_map_sensor;
    constexpr double kCosineOfOneDegree = 0.99984769515639127;
    const double cosine = 0.5 * (apart.rotation.trace() - 1);
    const bool same = looks_ > 0 && apart.translation.norm() < radius_ && cosine > kCosineOfOneDegree;
    if (!same) T_place_ = T_map_sensor;
    looks_ = same ? looks_ + 1 : 1;
    return 1.0 / looks_;
  }

 private:
  double radius_;
  Pose T_place_;
  int looks_ = 0;
};

}  // namespace evermap
