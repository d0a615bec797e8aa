// SPDX-FileCopyrightText: 2026 the evermap authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <Eigen/Core>

#include <evermap/geometry/gaussian.hpp>
#include <evermap/geometry/ray.hpp>
#include <evermap/update/parameters.hpp>

namespace evermap {

/// Default mode: where a ray's line comes closest to a leaf, as the leaf's Gaussian measures closeness.
struct Approach {
  double fraction;             ///< of the ray, at least 0; beyond 1 it lies behind the ray's end
  double mahalanobis_squared;  ///< d_M^2; the leaf's likelihood relative to its peak is exp(-d_M^2 / 2)
};
Approach closest_approach(const Ray& ray, const Gaussian& leaf);
/// The same, where the adjugate of the leaf's covariance is known.
Approach closest_approach(const Ray& ray, const Gaussian& leaf, const Eigen::Matrix3d& adjugate);
Eigen::Matrix3d adjugate_of(const Eigen::Matrix3d& covariance);

/// The plane a flat leaf lies in: its thinnest direction, when that is clearly thinner than the others.
struct Plane {
  Eigen::Vector3d normal = Eigen::Vector3d::Zero();
  double sigma = 0;   ///< [m] thickness of the leaf along the normal
  bool flat = false;  ///< whether the leaf has a plane at all

  /// Projects onto the plane.
  Eigen::Matrix3d within() const { return Eigen::Matrix3d::Identity() - normal * normal.transpose(); }
};
Plane plane_of(const Gaussian& leaf);

/// Whether a ray goes through a plane and, though it is off by `error` [m], ends beyond.
bool crosses(const Plane& plane, const Eigen::Vector3d& on_plane, const Ray& ray, double error,
             const UpdateParameters& parameters);

/// Where a leaf's surface may be, given its points and no more: few of them do not tell where else in the
/// voxel it is. The predictive Gaussian of a prior worth `extent_prior` points anywhere in a voxel of this
/// edge [m]; where a flat leaf lies across its plane is known.
Gaussian predictive(const Gaussian& leaf, const Plane& plane, double edge, double extent_prior);

/// A leaf that the rays of a scan are judged against: what no ray changes is computed once.
class JudgedLeaf {
 public:
  /// `edge` [m]: of the leaf's voxel. `error` [m]: of the scan's alignment there, see alignment_error().
  /// Keeps a reference to the parameters.
  JudgedLeaf(const Gaussian& leaf, double edge, double error, const UpdateParameters& parameters);

  /// Impact in [0, 1] of one bundle's ray that passes through the leaf, by the rules of the parameters.
  /// Beyond `free_fraction` of the ray, the noise of its range forbids a verdict. Not thread safe.
  double impact(const Ray& ray, const Eigen::Matrix3d& bundle_covariance, double free_fraction);

 private:
  double impact_by_approach(const Ray& ray, double free_fraction);
  /// The leaf's plane, and where its surface may be, given that.
  void find_plane();
  Approach crossing(const Ray& ray) const;

  Gaussian leaf_;
  double edge_, error_;  ///< [m]
  const UpdateParameters& parameters_;
  Gaussian anywhere_;                  ///< where the surface may be, whether the leaf is flat or not
  Eigen::Matrix3d adjugate_anywhere_;  ///< of its covariance
  bool is_plane_known_ = false;
  Plane plane_;
  Gaussian surface_;                 ///< of a flat leaf
  Eigen::Matrix3d surface_inverse_;  ///< of its covariance
};

}  // namespace evermap
