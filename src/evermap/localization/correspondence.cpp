// SPDX-FileCopyrightText: 2026 the evermap authors
// SPDX-License-Identifier: BSD-3-Clause
#include <algorithm>
#include <array>
#include <cmath>

#include <Eigen/Eigenvalues>
#include <Eigen/LU>

#include <evermap/localization/correspondence.hpp>

namespace evermap {
namespace {

/// The bundle's own voxel and those that share a face with it.
const std::array<Eigen::Vector3i, 7>& steps() {
  static const std::array<Eigen::Vector3i, 7> all = {
      {{0, 0, 0}, {-1, 0, 0}, {1, 0, 0}, {0, -1, 0}, {0, 1, 0}, {0, 0, -1}, {0, 0, 1}}};
  return all;
}

/// What M says along its stiffest axis and nowhere else.
Eigen::Matrix3d along_normal(const Eigen::Matrix3d& M) {
  Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d> eigen;
  eigen.computeDirect(M);
  const Eigen::Vector3d& lambda = eigen.eigenvalues();  // ascending
  const Eigen::Vector3d normal = eigen.eigenvectors().col(2);
  return (lambda[2] - std::max(0.0, lambda[1])) * normal * normal.transpose();
}

}  // namespace

std::optional<Correspondence> correspond(const Octree& map, const Gaussian& bundle) {
  std::optional<Correspondence> best;
  const auto voxel = map.grid().voxel(bundle.mean);
  if (!voxel) return best;
  for (const Eigen::Vector3i& step : steps()) {
    const Eigen::Vector3i near = *voxel + step;
    const Leaf* leaf = VoxelKey::in_range(near) ? map.find(VoxelKey::from_voxel(near)) : nullptr;
    if (leaf == nullptr || !leaf->occupied()) continue;
    const Eigen::Vector3d residual = leaf->gaussian(map.grid().center(near)).mean - bundle.mean;
    const Eigen::Matrix3d covariance = leaf->covariance_matrix() + bundle.covariance;
    // No eigenvalue exceeds the trace, so this is the least that e' M e can be; it spares most inverses.
    if (best && residual.squaredNorm() >= best->mahalanobis_squared * covariance.trace()) continue;
    const Eigen::Matrix3d information = covariance.inverse();
    const double mahalanobis_squared = residual.dot(information * residual);
    if (best && best->mahalanobis_squared <= mahalanobis_squared) continue;
    const double occupancy = 1 / (1 + std::exp(-static_cast<double>(leaf->log_odds)));
    best = {residual, information, mahalanobis_squared, occupancy};
  }
  if (best) best->information = along_normal(best->information);
  return best;
}

}  // namespace evermap
