// SPDX-FileCopyrightText: 2026 the evermap authors
// SPDX-License-Identifier: BSD-3-Clause
#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>

#include <Eigen/Eigenvalues>
#include <Eigen/LU>

#include <evermap/update/detail/paper_impact.hpp>

namespace evermap {

double closest_resemblance(const Ray& ray, const Eigen::Matrix3d& bundle_covariance, const Gaussian& leaf) {
  const Eigen::Matrix3d leaf_information = leaf.covariance.inverse();
  const Eigen::Vector3d d = ray.end - ray.origin;
  const double a = 2 * d.dot(leaf_information * d);
  const double b =
      (leaf_information * bundle_covariance).trace() - 2 * d.dot(leaf_information * (leaf.mean - ray.origin));
  const double c = -3;
  const double root = std::sqrt(b * b - 4 * a * c);
  // Both forms are the positive root; each is free of cancellation for its sign of b.
  const double t = b > 0 ? -2 * c / (b + root) : (root - b) / (2 * a);
  return std::min(t, 1.0);
}

Gaussian bundle_at(double t, const Ray& ray, const Eigen::Matrix3d& bundle_covariance) {
  return {ray.origin + t * (ray.end - ray.origin), t * bundle_covariance, 0};
}

Eigen::Vector3d densest_overlap(const Gaussian& leaf, const Gaussian& bundle_t) {
  const Eigen::Matrix3d both = leaf.covariance + bundle_t.covariance;
  return leaf.mean + leaf.covariance * (both.inverse() * (bundle_t.mean - leaf.mean));
}

double equation5(const Gaussian& leaf, const Gaussian& bundle_t, ImpactRule third_case) {
  const Eigen::Vector3d x_max = densest_overlap(leaf, bundle_t);
  if (mahalanobis_squared(x_max, leaf) > kChiSquared95) return 0;
  if (mahalanobis_squared(leaf.mean, bundle_t) <= kChiSquared95) return 1;
  const double distance = (leaf.mean - x_max).norm();
  const Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d> eigen(leaf.covariance, Eigen::EigenvaluesOnly);
  const double sigma_max = std::sqrt(eigen.eigenvalues()[2]);
  // Corrected: the printed case grows with distance, against its text and both neighbouring cases.
  if (third_case == ImpactRule::kEquation5Printed) return std::min(1.0, distance / (2 * sigma_max));
  return std::clamp(1 - distance / (std::sqrt(kChiSquared95) * sigma_max), 0.0, 1.0);
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
  // Each sigma point stands for a part of the leaf that, summed over all seven, restores its moments.
  constexpr double kPoints = 7;
  Gaussian rest;
  for (auto p = points.begin(); p != kept_end; ++p) {
    const Gaussian part{*p, Eigen::Matrix3d::Zero(), leaf.count / kPoints};
    rest = rest.count > 0 ? merge(rest, part) : part;
  }
  const double restore = kPoints / (2 * kChiSquared95);  // scatter of the points about the mean -> covariance
  rest.covariance *= restore;
  return rest;
}

}  // namespace evermap
