// SPDX-FileCopyrightText: 2026 the evermap authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <functional>
#include <vector>

#include <Eigen/Core>

namespace evermap {

/// A set of points of one frame, [m].
using Points = std::vector<Eigen::Vector3d>;

/// Distance [m] from each point of `from` to the nearest point of `to`; infinity when `to` is empty. Runs in
/// parallel in the caller's TBB arena, with the same result for any number of threads.
std::vector<double> nearest_distances(const Points& from, const Points& to);

/// How well the points of a map, one per leaf, stand for the true surface. Of an empty set the fraction and
/// the mean are NaN: there is nothing to say about it.
struct SurfaceComparison {
  std::vector<double> truth_to_map;  ///< [m] of each truth point to the nearest map point
  std::vector<double> map_to_truth;  ///< [m] of each map point to the nearest truth point

  double coverage(double tolerance) const;  ///< COV: fraction of the truth within `tolerance` [m] of the map
  double accuracy(double tolerance) const;  ///< ACC: fraction of the map within `tolerance` [m] of the truth
  double mean_truth_to_map() const;         ///< [m]
  double mean_map_to_truth() const;         ///< [m]
  double average_hausdorff_distance() const;  ///< AHD [m]: the larger of the two means
};

/// In parallel, like nearest_distances.
SurfaceComparison compare_surfaces(const Points& truth, const Points& map);

/// Fraction of `points` of which `predicate` ("the map still claims this point") is true; NaN without points.
/// Over unchanged surface it is the static accuracy SA, over removed surface 1 - DA.
double fraction_true(const Points& points, const std::function<bool(const Eigen::Vector3d&)>& predicate);

/// AA and HA: the geometric and the harmonic mean of SA and DA. Both are 0 when one of the two is, so no map
/// wins by keeping or by erasing everything.
double associated_accuracy(double static_accuracy, double dynamic_accuracy);
double harmonic_accuracy(double static_accuracy, double dynamic_accuracy);

}  // namespace evermap
