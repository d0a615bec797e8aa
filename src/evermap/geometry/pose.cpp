// SPDX-FileCopyrightText: 2026 the evermap authors
// SPDX-License-Identifier: BSD-3-Clause
#include <cmath>

#include <Eigen/SVD>

#include <evermap/geometry/pose.hpp>

namespace evermap {
namespace {

Eigen::Matrix3d skew(const Eigen::Vector3d& v) {
  Eigen::Matrix3d m;
  m << 0, -v.z(), v.y(), v.z(), 0, -v.x(), -v.y(), v.x(), 0;
  return m;
}

}  // namespace

bool is_rotation(const Eigen::Matrix3d& matrix, double tolerance) {
  return matrix.allFinite() &&
         (matrix * matrix.transpose() - Eigen::Matrix3d::Identity()).cwiseAbs().maxCoeff() <= tolerance &&
         matrix.determinant() > 0;
}

Eigen::Matrix3d nearest_rotation(const Eigen::Matrix3d& matrix) {
  const Eigen::JacobiSVD<Eigen::Matrix3d> svd(matrix, Eigen::ComputeFullU | Eigen::ComputeFullV);
  Eigen::Vector3d signs(1, 1, (svd.matrixU() * svd.matrixV().transpose()).determinant() < 0 ? -1 : 1);
  return svd.matrixU() * signs.asDiagonal() * svd.matrixV().transpose();
}

Pose exp(const Twist& twist) {
  const Eigen::Vector3d rho = twist.head<3>();
  const Eigen::Vector3d phi = twist.tail<3>();
  const double angle = phi.norm();
  const Eigen::Matrix3d K = skew(phi);
  // Below 1e-4 rad the Taylor series is exact to double precision and the quotients are not.
  const bool small = angle < 1e-4;
  const double a2 = angle * angle;
  const double A = small ? 1 - a2 / 6 : std::sin(angle) / angle;
  const double B = small ? 0.5 - a2 / 24 : (1 - std::cos(angle)) / a2;
  const double C = small ? 1.0 / 6 - a2 / 120 : (1 - A) / a2;
  const Eigen::Matrix3d I = Eigen::Matrix3d::Identity();
  return {I + A * K + B * K * K, (I + B * K + C * K * K) * rho};
}

Twist log(const Pose& pose) {
  const Eigen::AngleAxisd angle_axis(pose.rotation);
  const double angle = angle_axis.angle();
  const Eigen::Vector3d phi = angle * angle_axis.axis();
  const Eigen::Matrix3d K = skew(phi);
  const double a2 = angle * angle;
  const double D = angle < 1e-4 ? 1.0 / 12 + a2 / 720 : (1 - 0.5 * angle / std::tan(0.5 * angle)) / a2;
  Twist twist;
  twist << (Eigen::Matrix3d::Identity() - 0.5 * K + D * K * K) * pose.translation, phi;
  return twist;
}

}  // namespace evermap
