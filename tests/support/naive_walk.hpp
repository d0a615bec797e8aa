// SPDX-FileCopyrightText: 2026 the evermap authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <algorithm>
#include <cmath>
#include <limits>
#include <tuple>
#include <vector>

#include <Eigen/Core>

#include <evermap/geometry/ray.hpp>
#include <evermap/geometry/voxel_key.hpp>

namespace evermap::test {

/// A voxel on a ray's way; times are shares of the ray's length.
struct NaiveStep {
  Eigen::Vector3i voxel;
  double entry;
  double exit;  ///< infinity when the ray never leaves
};

/// All voxels a ray passes through, the slow and obvious way: list every boundary of every axis that the ray
/// crosses between its ends, sort the crossings by time (ties by axis), and cross one after the other.
///
/// A ray that ends on a boundary crosses it; one that begins on a boundary crosses it only downwards, since
/// a boundary belongs to the voxel above.
inline std::vector<NaiveStep> naive_walk(const VoxelGrid& grid, const Ray& ray) {
  const auto start = grid.voxel(ray.origin);
  if (!start || !grid.voxel(ray.end)) return {};
  struct Crossing {
    double time;
    int axis;
    int step;
  };
  std::vector<Crossing> crossings;
  double beyond_end = std::numeric_limits<double>::infinity();  // the first crossing after the ray has ended
  for (int axis = 0; axis < 3; ++axis) {
    const double from = (ray.origin[axis] - grid.origin[axis]) / grid.edge;
    const double per_time = 1 / ((ray.end[axis] - ray.origin[axis]) / grid.edge);
    if (std::isinf(per_time)) continue;
    const int step = per_time > 0 ? 1 : -1;
    int boundary = per_time > 0 ? (*start)[axis] + 1 : (*start)[axis];
    double time = (boundary - from) * per_time;
    for (; time <= 1; boundary += step, time = (boundary - from) * per_time) {
      crossings.push_back({time, axis, step});
    }
    beyond_end = std::min(beyond_end, time);
  }
  std::sort(crossings.begin(), crossings.end(), [](const Crossing& a, const Crossing& b) {
    return std::tie(a.time, a.axis) < std::tie(b.time, b.axis);
  });
  std::vector<NaiveStep> steps;
  NaiveStep now{*start, 0, 0};
  for (const Crossing& crossing : crossings) {
    now.exit = crossing.time;
    steps.push_back(now);
    now.entry = crossing.time;
    now.voxel[crossing.axis] += crossing.step;
  }
  now.exit = beyond_end;
  steps.push_back(now);
  return steps;
}

}  // namespace evermap::test
