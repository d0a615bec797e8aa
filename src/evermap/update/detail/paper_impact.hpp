// SPDX-FileCopyrightText: 2026 the evermap authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <optional>

#include <Eigen/Core>

#include <evermap/geometry/gaussian.hpp>
#include <evermap/geometry/ray.hpp>
#include <evermap/update/parameters.hpp>

namespace evermap {

// The paper's equations 3 to 6, all of paper mode that the default mode does not share. Pure.

/// Equation (3): where along the ray the travelling bundle N(o + t d, t S_R) resembles the leaf most, by
/// Kullback-Leibler divergence. Returns t in (0, 1]; the divergence is strictly convex in t, so clamping
/// gives the exact optimum on the ray. REQUIRES: both covariances are positive definite; the ray has a
/// length.
double closest_resemblance(const Ray& ray, const Eigen::Matrix3d& bundle_covariance, const Gaussian& leaf);

/// The travelling bundle at t: N(o + t d, t S_R).
Gaussian bundle_at(double t, const Ray& ray, const Eigen::Matrix3d& bundle_covariance);

/// Equation (4): where the product of both densities is greatest.
Eigen::Vector3d densest_overlap(const Gaussian& leaf, const Gaussian& bundle_t);

/// Equation (5): the Ray-Bundle-Impact-Factor in [0, 1].
double equation5(const Gaussian& leaf, const Gaussian& bundle_t, ImpactRule third_case);

/// Equation (6): N_V \ N_R, the sigma points of the leaf outside the bundle's 95 % ellipsoid, refitted. None
/// when all of them lie inside.
std::optional<Gaussian> sigma_point_difference(const Gaussian& leaf, const Gaussian& bundle_t);

}  // namespace evermap
