// SPDX-FileCopyrightText: 2026 the evermap authors
// SPDX-License-Identifier: BSD-3-Clause
#include <algorithm>
#include <cmath>

#include <Eigen/LU>

#include <evermap/update/detail/impact.hpp>
#include <evermap/update/detail/paper_impact.hpp>

namespace evermap {

Eigen::Matrix3d adjugate_of(const Eigen::Matrix3d& S) {
  Eigen::Matrix3d adjugate;
  adjugate << S.col(1).cross(S.col(2)), S.col(2).cross(S.col(0)), S.col(0).cross(S.col(1));
  return adjugate;
}

Approach closest_approach(const Ray& ray, const Gaussian& leaf, const Eigen::Matrix3d& adjugate) {
  // The line o + t d passes a Gaussian at the squared Mahalanobis distance w' S w / (d' adj(S) d), where
  // w = d x (mu - o) and adj(S) = det(S) S^-1: no inverse is needed.
  const Eigen::Vector3d d = ray.end - ray.origin;
  const Eigen::Vector3d to_leaf = leaf.mean - ray.origin;
  const Eigen::Vector3d adjugate_d = adjugate * d;
  const double scale = d.dot(adjugate_d);
  const double fraction = to_leaf.dot(adjugate_d) / scale;
  if (fraction < 0) return {0, mahalanobis_squared(ray.origin, leaf)};
  const Eigen::Vector3d w = d.cross(to_leaf);
  return {fraction, w.dot(leaf.covariance * w) / scale};
}

Approach closest_approach(const Ray& ray, const Gaussian& leaf) {
  return closest_approach(ray, leaf, adjugate_of(leaf.covariance));
}

Plane plane_of(const Gaussian& leaf) {
  constexpr double kFlat = 0.2;  // variance across the plane, relative to the smaller one within it
  // Asked for so often that a solver for all eigenvectors took a third of an update. The characteristic
  // polynomial x^3 - trace x^2 + minors x - determinant has three roots of at least 0. From 0, Newton's steps
  // come up to the smallest, and never beyond it.
  const Eigen::Matrix3d& S = leaf.covariance;
  const double trace = S.trace();
  const double minors = S(0, 0) * S(1, 1) - S(0, 1) * S(0, 1) + S(0, 0) * S(2, 2) - S(0, 2) * S(0, 2) +
                        S(1, 1) * S(2, 2) - S(1, 2) * S(1, 2);
  const double determinant = S.determinant();
  // The middle root is at most minors / largest, the largest at least the mean weighted by the roots.
  const double most_of_middle = minors * trace / (trace * trace - 2 * minors);
  constexpr int kMostSteps = 12;  // a flat leaf needs four
  double smallest = 0;
  for (int i = 0; i < kMostSteps; ++i) {
    const double value = ((smallest - trace) * smallest + minors) * smallest - determinant;
    const double slope = (3 * smallest - 2 * trace) * smallest + minors;
    if (!(value < 0 && slope > 0)) break;
    const double step = -value / slope;
    smallest += step;
    if (smallest > kFlat * std::min(most_of_middle, (trace - smallest) / 2)) return {};
    if (step < 1e-7 * smallest) break;  // the next one would be its square
  }
  const double sum_of_others = trace - smallest;
  const double product_of_others = minors - smallest * sum_of_others;
  const double apart = std::sqrt(std::max(0.0, sum_of_others * sum_of_others - 4 * product_of_others));
  if (!(smallest < kFlat * 0.5 * (sum_of_others - apart))) return {};
  // What S - smallest I leaves of space lies in the plane, and is spanned by any two of its columns that
  // differ.
  const Eigen::Matrix3d within = S - smallest * Eigen::Matrix3d::Identity();
  Eigen::Vector3d normal = within.col(0).cross(within.col(1));
  for (const Eigen::Vector3d& other : {Eigen::Vector3d(within.col(1).cross(within.col(2))),
                                       Eigen::Vector3d(within.col(2).cross(within.col(0)))}) {
    if (other.squaredNorm() > normal.squaredNorm()) normal = other;
  }
  return {normal.normalized(), std::sqrt(smallest), true};
}

Gaussian predictive(const Gaussian& leaf, const Plane& plane, double edge, double extent_prior) {
  const double anywhere = edge * edge / 12;
  const double unseen = anywhere * extent_prior / (leaf.count + extent_prior);
  const Eigen::Matrix3d directions = plane.flat ? plane.within() : Eigen::Matrix3d::Identity();
  return {leaf.mean, leaf.covariance + unseen * directions, leaf.count};
}

bool crosses(const Plane& plane, const Eigen::Vector3d& on_plane, const Ray& ray, double error,
             const UpdateParameters& parameters) {
  const double origin_side = plane.normal.dot(ray.origin - on_plane);
  const double end_side = plane.normal.dot(ray.end - on_plane);
  return origin_side * end_side < 0 &&
         std::abs(end_side) > 3 * plane.sigma + parameters.surface_tolerance * error;
}

namespace {

/// Whether a surface that is off by `error` [m] may stand here although it is what the ray hit: the more a
/// ray grazes a surface, the farther before its end.
bool is_near_end(double fraction, const Ray& ray, double error, const UpdateParameters& parameters) {
  return (1 - fraction) * ray.length() < parameters.hit_margin * error;
}

/// How likely the surface is where a ray comes closest, relative to the middle of it.
double likelihood_of(const Approach& approach, double plateau) {
  return std::exp(-0.5 * std::max(0.0, approach.mahalanobis_squared - plateau));
}

}  // namespace

JudgedLeaf::JudgedLeaf(const Gaussian& leaf, double edge, double error, const UpdateParameters& parameters)
    : leaf_(leaf), edge_(edge), error_(error), parameters_(parameters) {
  if (parameters.impact != ImpactRule::kClosestApproach) return;
  anywhere_ = predictive(leaf, {}, edge, parameters.extent_prior);
  adjugate_anywhere_ = adjugate_of(anywhere_.covariance);
}

void JudgedLeaf::find_plane() {
  is_plane_known_ = true;
  plane_ = plane_of(leaf_);
  if (!plane_.flat) return;
  surface_ = predictive(leaf_, plane_, edge_, parameters_.extent_prior);
  surface_inverse_ = surface_.covariance.inverse();
}

/// Where a ray goes through the plane of a flat leaf. REQUIRES: its ends lie on either side.
Approach JudgedLeaf::crossing(const Ray& ray) const {
  const double origin_side = plane_.normal.dot(ray.origin - surface_.mean);
  const double end_side = plane_.normal.dot(ray.end - surface_.mean);
  const double fraction = origin_side / (origin_side - end_side);
  const Eigen::Vector3d from_mean = ray.origin + fraction * (ray.end - ray.origin) - surface_.mean;
  return {fraction, from_mean.dot(surface_inverse_ * from_mean)};
}

double JudgedLeaf::impact_by_approach(const Ray& ray, double free_fraction) {
  const double patch = parameters_.patch_radius * parameters_.patch_radius;
  Approach approach = closest_approach(ray, anywhere_, adjugate_anywhere_);
  // A bound for all leaves, and exp(-x) <= 1 / (1 + x), turn most rays away before anything dear is computed.
  if (parameters_.least_impact * (1 + 0.5 * (approach.mahalanobis_squared - patch)) > 1) return 0;
  if (!is_plane_known_) find_plane();
  const bool is_plane_decisive = parameters_.surface_crossing && plane_.flat;
  if (is_plane_decisive && !crosses(plane_, leaf_.mean, ray, error_, parameters_)) return 0;
  // The line of a ray that grazes a surface comes close to it long before it goes through.
  if (plane_.flat) approach = is_plane_decisive ? crossing(ray) : closest_approach(ray, surface_);
  const double likelihood = likelihood_of(approach, plane_.flat ? patch : 0);
  if (likelihood < parameters_.least_impact || approach.fraction > free_fraction) return 0;
  return !is_plane_decisive && is_near_end(approach.fraction, ray, error_, parameters_) ? 0 : likelihood;
}

double JudgedLeaf::impact(const Ray& ray, const Eigen::Matrix3d& bundle_covariance, double free_fraction) {
  if (parameters_.impact == ImpactRule::kClosestApproach) return impact_by_approach(ray, free_fraction);
  const double t = closest_resemblance(ray, bundle_covariance, leaf_);
  if (t > free_fraction || is_near_end(t, ray, error_, parameters_)) return 0;
  return equation5(leaf_, bundle_at(t, ray, bundle_covariance), parameters_.impact);
}

}  // namespace evermap
