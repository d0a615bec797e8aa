// SPDX-FileCopyrightText: 2026 the evermap authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cmath>
#include <support/random_geometry.hpp>

#include <Eigen/Core>
#include <Eigen/LU>

#include <evermap/geometry/gaussian.hpp>
#include <evermap/geometry/ray.hpp>

namespace evermap::test {

/// A bundle whose ray meets a leaf, or passes it.
struct Encounter {
  Ray ray;
  Gaussian bundle;
  Gaussian leaf;
};

/// Leaves near the ray and metres off it, round, flat and tiny; rays that end behind, at and before the leaf.
inline Encounter random_encounter(Random& random) {
  const Eigen::Vector3d origin = random.in_cube(50);
  const double distance = random.log_uniform(0.3, 200);
  const Eigen::Vector3d u = random.direction();
  const double off_ray = random.chance(0.2) ? 5.0 : 0.1;
  Gaussian leaf{origin + distance * u + random.in_cube(off_ray), {}, 20};
  switch (random.integer(0, 2)) {
    case 0:
      leaf.covariance = random.covariance(0.005, 0.15);
      break;
    case 1:
      leaf.covariance = random.covariance({random.log_uniform(0.001, 0.005), 0.12, 0.09});
      break;
    default:
      leaf.covariance = random.covariance(1e-5, 3e-5);
      break;
  }
  const Eigen::Vector3d end = origin + distance * random.uniform(0.5, 4) * u;
  Gaussian bundle{end, random.covariance(0.002, 0.15), 8};
  if (random.chance(0.1)) bundle.covariance *= 1e-6;
  return {{origin, end}, bundle, leaf};
}

/// D(N_R(t) || N_V) of the bundle travelling along the ray, in long double; unclamped, for any t > 0.
class TravellingDivergence {
 public:
  using Real = long double;
  using Matrix = Eigen::Matrix<Real, 3, 3>;
  using Vector = Eigen::Matrix<Real, 3, 1>;

  explicit TravellingDivergence(const Encounter& e)
      : information_(e.leaf.covariance.cast<Real>().inverse()),
        from_leaf_(e.ray.origin.cast<Real>() - e.leaf.mean.cast<Real>()),
        d_(e.ray.end.cast<Real>() - e.ray.origin.cast<Real>()),
        trace_((information_ * e.bundle.covariance.cast<Real>()).trace()),
        log_determinants_(std::log(e.leaf.covariance.cast<Real>().determinant()) -
                          std::log(e.bundle.covariance.cast<Real>().determinant())) {}

  Real operator()(Real t) const {
    const Vector apart = from_leaf_ + t * d_;
    return (t * trace_ + apart.dot(information_ * apart) - 3 + log_determinants_ - 3 * std::log(t)) / 2;
  }
  Real slope(Real t) const { return (trace_ + 2 * d_.dot(information_ * (from_leaf_ + t * d_)) - 3 / t) / 2; }
  Real curvature(Real t) const { return d_.dot(information_ * d_) + 3 / (2 * t * t); }

  /// Newton's method in log t, where the strictly convex divergence cannot leave its domain; bracketed.
  Real minimum() const {
    Real low = -60, high = 20, s = 0;
    for (int i = 0; i < 200 && high - low > 1e-15L; ++i) {
      const Real t = std::exp(s);
      const Real slope_s = t * slope(t);
      (slope_s > 0 ? high : low) = s;
      const Real newton = s - slope_s / (t * slope(t) + t * t * curvature(t));
      const Real next = newton > low && newton < high ? newton : (low + high) / 2;
      if (std::abs(next - s) < 1e-17L) break;
      s = next;
    }
    return std::exp(s);
  }

 private:
  Matrix information_;
  Vector from_leaf_, d_;
  Real trace_, log_determinants_;
};

/// Where f is least between `low` and `high`, by values alone.
inline long double golden_section(const TravellingDivergence& f, long double low, long double high) {
  const long double ratio = (std::sqrt(5.0L) - 1) / 2;
  while (high - low > 1e-10L * high) {
    const long double a = high - ratio * (high - low);
    const long double b = low + ratio * (high - low);
    if (f(a) < f(b)) {
      high = b;
    } else {
      low = a;
    }
  }
  return (low + high) / 2;
}

/// The bundle on its way, at t of its ray.
inline Gaussian travelling(const Encounter& e, double t) {
  return {e.ray.origin + t * (e.ray.end - e.ray.origin), t * e.bundle.covariance, e.bundle.count};
}

}  // namespace evermap::test
