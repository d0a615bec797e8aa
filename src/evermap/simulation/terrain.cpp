// SPDX-FileCopyrightText: 2026 the evermap authors
// SPDX-License-Identifier: BSD-3-Clause
#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>
#include <utility>

#include <evermap/simulation/noise.hpp>
#include <evermap/simulation/terrain.hpp>

namespace evermap {
namespace {

/// From 0 at x = 0 to 1 at x = 1 without an edge.
double smooth_step(double x) {
  x = std::clamp(x, 0.0, 1.0);
  return x * x * (3 - 2 * x);
}

/// In [-1, 1], the value at a node of the lattice.
double node_value(std::int64_t x, std::int64_t y, std::uint64_t seed) {
  const auto row = static_cast<std::uint64_t>(y) << 32;
  return 2 * uniform(seed, row ^ (static_cast<std::uint64_t>(x) & 0xFFFFFFFFU)) - 1;
}

/// Distance [m] to a rectangle with rounded corners; negative inside.
double distance_to(const Terraces& pit, const Eigen::Vector2d& p) {
  const Eigen::Vector2d q =
      (p - pit.center).cwiseAbs() - 0.5 * pit.size + Eigen::Vector2d::Constant(pit.corner);
  return q.cwiseMax(0).norm() + std::min(q.maxCoeff(), 0.0) - pit.corner;
}

double distance_to(const Eigen::Vector2d& from, const Eigen::Vector2d& to, const Eigen::Vector2d& p) {
  const Eigen::Vector2d edge = to - from;
  return (from + std::clamp((p - from).dot(edge) / edge.squaredNorm(), 0.0, 1.0) * edge - p).norm();
}

}  // namespace

HeightFunction slope(const Eigen::Vector2d& grade) {
  return [grade](double x, double y) { return grade.x() * x + grade.y() * y; };
}

HeightFunction waves(const Waves& waves) {
  const Eigen::Vector2d rate = 2 * std::numbers::pi * waves.length.cwiseInverse();
  return [waves, rate](double x, double y) {
    return waves.amplitude * std::sin(rate.x() * x + waves.phase) * std::cos(rate.y() * y);
  };
}

HeightFunction roughness(const Roughness& roughness) {
  return [roughness](double x, double y) {
    const double column = std::floor(x / roughness.size);
    const double row = std::floor(y / roughness.size);
    const auto i = static_cast<std::int64_t>(column);
    const auto j = static_cast<std::int64_t>(row);
    const double u = smooth_step(x / roughness.size - column);
    const double v = smooth_step(y / roughness.size - row);
    const auto along_x = [&](std::int64_t of_row) {
      return std::lerp(node_value(i, of_row, roughness.seed), node_value(i + 1, of_row, roughness.seed), u);
    };
    return roughness.amplitude * std::lerp(along_x(j), along_x(j + 1), v);
  };
}

HeightFunction terraces(const Terraces& pit) {
  constexpr double kWobbleLength = 12;  ///< [m] about what a shovel takes in one go
  const HeightFunction wobble = roughness({pit.wobble, kWobbleLength});
  return [pit, wobble](double x, double y) {
    double beyond = distance_to(pit, {x, y}) + wobble(x, y);
    double height = 0;
    for (int bench = 0; bench < pit.count && beyond > 0; ++bench) {
      height += pit.height * std::min(beyond / pit.face, 1.0);
      beyond -= pit.face + pit.width;
    }
    return height;
  };
}

HeightFunction embankment(const Embankment& bank) {
  return [bank](double x, double y) {
    double distance = std::numeric_limits<double>::infinity();
    for (std::size_t i = 1; i < bank.line.size(); ++i) {
      distance = std::min(distance, distance_to(bank.line[i - 1], bank.line[i], {x, y}));
    }
    return bank.height * (1 - smooth_step((distance - 0.5 * bank.width) / bank.side));
  };
}

HeightFunction sum(std::vector<HeightFunction> features) {
  return [features = std::move(features)](double x, double y) {
    double height = 0;
    for (const HeightFunction& feature : features) height += feature(x, y);
    return height;
  };
}

Pose standing_pose(const HeightFunction& ground, const Place& at, double reach) {
  const Eigen::Vector2d ahead(reach * std::cos(at.yaw), reach * std::sin(at.yaw));
  const Eigen::Vector2d left(-ahead.y(), ahead.x());
  const auto height = [&](const Eigen::Vector2d& p) { return ground(p.x(), p.y()); };
  const double front = height(at.xy + ahead);
  const double back = height(at.xy - ahead);
  const double port = height(at.xy + left);
  const double starboard = height(at.xy - left);
  const Eigen::Vector3d x(2 * ahead.x(), 2 * ahead.y(), front - back);
  const Eigen::Vector3d y(2 * left.x(), 2 * left.y(), port - starboard);
  const Eigen::Vector3d up = x.cross(y).normalized();
  Pose T_map_stand;
  T_map_stand.rotation << x.normalized(), up.cross(x).normalized(), up;
  T_map_stand.translation << at.xy, (front + back + port + starboard) / 4;
  return T_map_stand;
}

}  // namespace evermap
