// SPDX-FileCopyrightText: 2026 the evermap authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cmath>
#include <cstdint>
#include <random>

#include <Eigen/Core>
#include <Eigen/Geometry>

#include <evermap/geometry/gaussian.hpp>

namespace evermap::test {

/// Random geometry that is the same on every run.
class Random {
 public:
  explicit Random(std::uint64_t seed) : engine_(seed) {}

  double uniform(double low, double high) { return low + (high - low) * unit_(engine_); }
  double log_uniform(double low, double high) { return std::exp(uniform(std::log(low), std::log(high))); }
  double normal() { return normal_(engine_); }
  int integer(int low, int high) {  // both included
    return std::uniform_int_distribution<int>(low, high)(engine_);
  }
  bool chance(double probability) { return uniform(0, 1) < probability; }

  Eigen::Vector3d in_cube(double half_edge) {
    const double x = uniform(-half_edge, half_edge);
    const double y = uniform(-half_edge, half_edge);
    return {x, y, uniform(-half_edge, half_edge)};
  }
  Eigen::Vector3d normal3() {
    const double x = normal();
    const double y = normal();
    return {x, y, normal()};
  }
  Eigen::Vector3d direction() { return normal3().normalized(); }
  Eigen::Matrix3d rotation() {
    const double w = normal();
    const Eigen::Vector3d v = normal3();
    return Eigen::Quaterniond(w, v.x(), v.y(), v.z()).normalized().toRotationMatrix();
  }

  /// Covariance with these standard deviations [m] along random axes.
  Eigen::Matrix3d covariance(const Eigen::Vector3d& sigma) {
    const Eigen::Matrix3d axes = rotation();
    const Eigen::Matrix3d S = axes * sigma.cwiseAbs2().asDiagonal() * axes.transpose();
    return 0.5 * (S + S.transpose());
  }
  /// Covariance with standard deviations [m] between `low` and `high`.
  Eigen::Matrix3d covariance(double low, double high) {
    const double x = log_uniform(low, high);
    const double y = log_uniform(low, high);
    return covariance(Eigen::Vector3d(x, y, log_uniform(low, high)));
  }

  std::mt19937_64& engine() { return engine_; }

 private:
  std::mt19937_64 engine_;
  std::uniform_real_distribution<double> unit_;
  std::normal_distribution<double> normal_;
};

}  // namespace evermap::test
