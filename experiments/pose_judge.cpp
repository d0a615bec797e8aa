// SPDX-FileCopyrightText: 2026 the evermap authors
// SPDX-License-Identifier: BSD-3-Clause
#include "experiments/pose_judge.hpp"

#include <algorithm>
#include <cmath>
#include <optional>
#include <vector>

#include <Eigen/Eigenvalues>

#include <evermap/localization/detail/perturbation.hpp>

namespace evermap {
namespace {

using Hessian = Eigen::Matrix<double, 6, 6>;

/// The normal of what a ray meets, by two rays beside it; none at edges.
std::optional<Eigen::Vector3d> normal_at(const RayCaster& world, const Eigen::Vector3d& origin,
                                         const Eigen::Vector3d& direction) {
  constexpr double kBeside = 1e-3;  // [rad]
  const Eigen::Vector3d u = direction.unitOrthogonal();
  const Eigen::Vector3d v = direction.cross(u);
  const auto meet = [&](const Eigen::Vector3d& along) -> std::optional<std::pair<Eigen::Vector3d, int>> {
    const auto hit = world.first_hit(origin, along);
    if (!hit) return std::nullopt;
    return std::pair{Eigen::Vector3d(origin + hit->range * along), hit->object};
  };
  const auto middle = meet(direction);
  const auto right = meet((direction + kBeside * u).normalized());
  const auto above = meet((direction + kBeside * v).normalized());
  if (!middle || !right || !above) return std::nullopt;
  if (middle->second != right->second || middle->second != above->second) return std::nullopt;
  return (right->first - middle->first).cross(above->first - middle->first).normalized();
}

}  // namespace

PoseJudge::PoseJudge(const RayCaster& world, const std::vector<Eigen::Vector3d>& points,
                     const Pose& T_map_sensor)
    : T_map_sensor_(T_map_sensor) {
  constexpr std::size_t kAsked = 2000;      // points, evenly over the scan
  constexpr double kNoise = 0.02;           // [m] of a range
  constexpr double kLeastAccuracy = 0.005;  // [m]
  double squared_ranges = 0;
  for (const Eigen::Vector3d& p : points) squared_ranges += p.squaredNorm();
  lever_ = std::sqrt(squared_ranges / std::max(1.0, static_cast<double>(points.size())));
  Hessian information = Hessian::Zero();
  const std::size_t step = 1 + points.size() / kAsked;
  for (std::size_t i = 0; i < points.size(); i += step) {
    const Eigen::Vector3d from_sensor = T_map_sensor.rotation * points[i];
    const auto normal = normal_at(world, T_map_sensor.translation, from_sensor.normalized());
    if (!normal) continue;
    Twist row;
    row << *normal, from_sensor.cross(*normal) / lever_;
    information += row * row.transpose() / (kNoise * kNoise);
  }
  const Eigen::SelfAdjointEigenSolver<Hessian> eigen(information);
  const auto known = (eigen.eigenvalues().array() > 1 / (kLeastAccuracy * kLeastAccuracy)).count();
  observable_ = eigen.eigenvectors().rightCols(known);
}

PoseJudge::Error PoseJudge::error(const Pose& T_map_found) const {
  Twist off = difference(T_map_sensor_, T_map_found);
  off.tail<3>() *= lever_;
  const Twist seen = observable_ * (observable_.transpose() * off);
  return {seen.head<3>().norm(), seen.tail<3>().norm() / lever_};
}

}  // namespace evermap
