// SPDX-FileCopyrightText: 2026 the evermap authors
// SPDX-License-Identifier: BSD-3-Clause
#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>

#include <Eigen/Eigenvalues>
#include <Eigen/Geometry>
#include <Eigen/LU>

#include <evermap/update/leaf_update.hpp>

namespace evermap {
namespace {

/// Log-odds of a leaf after its first hit: `confirmations` hits make it positive.
double first_hit(const UpdateParameters& parameters) {
  return parameters.hit * (2 - parameters.confirmations);
}

/// Log-odds after one more hit: full steps to what a few scans can tell, small ones beyond.
double raised(double log_odds, const UpdateParameters& parameters) {
  if (log_odds < parameters.max_log_odds) return std::min(log_odds + parameters.hit, parameters.max_log_odds);
  return std::min(log_odds + parameters.firming, std::max(parameters.firm_log_odds, parameters.max_log_odds));
}

}  // namespace

void confirm(Leaf& leaf, const Gaussian& bundle, const Eigen::Vector3d& center_map,
             const UpdateParameters& parameters) {
  const bool is_new = leaf.count <= 0;
  Gaussian surface = is_new ? bundle : merge(leaf.gaussian(center_map), bundle);
  surface.count = std::min(surface.count, parameters.max_count);
  leaf.set_gaussian(surface, center_map);
  constexpr double kRounding = 1e-5;  // of stored log-odds: it must not turn the last 0 into occupied
  const double log_odds = is_new ? std::min(first_hit(parameters), parameters.max_log_odds)
                                 : raised(static_cast<double>(leaf.log_odds), parameters);
  leaf.log_odds = std::abs(log_odds) < kRounding ? 0 : static_cast<float>(log_odds);
}

bool contradict(Leaf& leaf, double impact, const UpdateParameters& parameters) {
  const bool was_occupied = leaf.occupied();
  leaf.log_odds = static_cast<float>(leaf.log_odds - impact * parameters.miss);
  // The next hits outweigh what is in doubt. A count of 0 would say that the leaf is new.
  const auto count = static_cast<double>(leaf.count);
  const double trusted = std::max(std::min(count, 1.0), count * (1 - impact * parameters.forgetting));
  leaf.count = static_cast<float>(trusted);
  return was_occupied ? leaf.occupied() : leaf.log_odds >= static_cast<float>(first_hit(parameters));
}

std::optional<Gaussian> sigma_point_difference(const Gaussian& leaf, const Gaussian& bundle_t) {
  const Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d> eigen(leaf.covariance);
  std::array<Eigen::Vector3d, 7> points;
  points[0] = leaf.mean;
  for (std::size_t axis = 0; axis < 3; ++axis) {
    const auto column = static_cast<Eigen::Index>(axis);
    const double reach = std::sqrt(kChiSquared95 * std::max(0.0, eigen.eigenvalues()[column]));
    points[1 + 2 * axis] = leaf.mean + reach * eigen.eigenvectors().col(column);
    points[2 + 2 * axis] = leaf.mean - reach * eigen.eigenvectors().col(column);
  }
  const auto inside = [&](const Eigen::Vector3d& p) {
    return mahalanobis_squared(p, bundle_t) <= kChiSquared95;
  };
  const auto kept_end = std::remove_if(points.begin(), points.end(), inside);
  const auto kept = static_cast<double>(kept_end - points.begin());
  if (kept == 0) return std::nullopt;
  if (kept_end == points.end()) return leaf;
  // Each sigma point stands for a share of the leaf that, summed over all seven, restores its moments.
  constexpr double kPoints = 7;
  Gaussian rest;
  for (auto p = points.begin(); p != kept_end; ++p) {
    const Gaussian share{*p, Eigen::Matrix3d::Zero(), leaf.count / kPoints};
    rest = rest.count > 0 ? merge(rest, share) : share;
  }
  const double restore = kPoints / (2 * kChiSquared95);  // scatter of the points about the mean -> covariance
  rest.covariance *= restore;
  return rest;
}

Gaussian soft_difference(const Gaussian& leaf, const Ray& ray, const Gaussian& bundle, double rho) {
  // Two directions across the ray; the cylinder has no extent along it.
  const Eigen::Vector3d u = (ray.end - ray.origin).normalized();
  Eigen::Matrix<double, 3, 2> across;
  across.col(0) = u.unitOrthogonal();
  across.col(1) = u.cross(across.col(0));
  const Eigen::Matrix2d S_bundle = across.transpose() * bundle.covariance * across;
  const Eigen::Matrix2d S_both = S_bundle + across.transpose() * leaf.covariance * across;
  const Eigen::Matrix2d S_both_inverse = S_both.inverse();
  const Eigen::Vector2d apart = across.transpose() * (ray.origin - leaf.mean);  // from the leaf to the axis
  const double taken = rho * std::sqrt(S_bundle.determinant() / S_both.determinant()) *
                       std::exp(-0.5 * apart.dot(S_both_inverse * apart));
  // N_V times the cylinder is `taken` of a Gaussian: the Kalman update of the leaf by the axis.
  const Eigen::Matrix<double, 3, 2> gain = leaf.covariance * across * S_both_inverse;
  const Gaussian product{leaf.mean + gain * apart,
                         leaf.covariance - gain * across.transpose() * leaf.covariance, taken * leaf.count};
  return remove(leaf, product).value_or(leaf);
}

}  // namespace evermap
