// SPDX-FileCopyrightText: 2026 the evermap authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <Eigen/Core>

#include <evermap/geometry/gaussian.hpp>
#include <evermap/geometry/ray.hpp>
#include <evermap/update/parameters.hpp>

namespace evermap {

/// Equation (3): where along the ray the travelling bundle N(o + t d, t S_R) resembles the leaf most, by
/// Kullback-Leibler divergence. Returns t in (0, 1]; the divergence is strictly convex in t, so clamping
/// gives the exact optimum on the ray. REQUIRES: both covariances are positive definite; the ray has a
/// length.
double closest_resemblance(const Ray& ray, const Eigen::Matrix3d& bundle_covariance, const Gaussian& leaf);

/// The travelling bundle at t: N(o + t d, t S_R).
Gaussian bundle_at(double t, const Ray& ray, const Eigen::Matrix3d& bundle_covariance);

/// Equation (4): where the product of both densities is greatest.
Eigen::Vector3d densest_overlap(const Gaussian& leaf, const Gaussian& bundle_t);

/// Equation (5): the Ray-Bundle-Impact-Factor in [0, 1], paper mode.
double equation5(const Gaussian& leaf, const Gaussian& bundle_t, ImpactRule third_case);

/// Default mode: where a ray's line comes closest to a leaf, as the leaf's Gaussian measures closeness.
struct Approach {
  double share;                ///< of the ray, at least 0; beyond 1 it lies behind the ray's end
  double mahalanobis_squared;  ///< d_M^2; the leaf's likelihood relative to its peak is exp(-d_M^2 / 2)
};
Approach closest_approach(const Ray& ray, const Gaussian& leaf);

/// The plane a flat leaf lies in: its thinnest direction, when that is clearly thinner than the others.
struct Plane {
  Eigen::Vector3d normal;
  double sigma;  ///< [m] thickness of the leaf along the normal
  bool flat;     ///< whether the leaf has a plane at all
};
Plane plane_of(const Gaussian& leaf);

/// Impact in [0, 1] of one bundle's ray on a leaf that it passes through, by the rules of `parameters`. Pure.
/// `free_share`: of the ray, is free for all that its range's noise may be; beyond it the ray says nothing.
/// `error`: of the scan's alignment [m], see alignment_error().
double impact(const Gaussian& leaf, const Ray& ray, const Eigen::Matrix3d& bundle_covariance,
              double free_share, double error, const UpdateParameters& parameters);

}  // namespace evermap
