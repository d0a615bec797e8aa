// SPDX-FileCopyrightText: 2026 the evermap authors
// SPDX-License-Identifier: BSD-3-Clause
#include <algorithm>
#include <cmath>
#include <span>

#include <Eigen/LU>

#include <evermap/geometry/detail/for_each_index.hpp>
#include <evermap/localization/detail/coarse_map.hpp>
#include <evermap/localization/detail/correspondence.hpp>
#include <evermap/localization/detail/factor.hpp>
#include <evermap/localization/detail/perturbation.hpp>
#include <evermap/localization/detail/registration.hpp>
#include <evermap/localization/detail/robust_kernel.hpp>
#include <evermap/localization/detail/solver.hpp>

namespace evermap {
namespace {

constexpr double kLeastBundleEdge = 0.4;  ///< [m]
constexpr std::size_t kChunk = 256;       ///< bundles per task; fixed, so that sums do not depend on threads

using Factors = std::vector<std::optional<Factor>>;  ///< one a bundle, none where it is off the map

Factors match(const Octree& map, const std::vector<Gaussian>& bundles_sensor, const Pose& T_map_sensor) {
  Factors factors(bundles_sensor.size());
  for_each_chunk(factors.size(), kChunk, [&](std::size_t, std::size_t begin, std::size_t end) {
    const auto matches = correspond(map, std::span(bundles_sensor).subspan(begin, end - begin), T_map_sensor);
    for (std::size_t i = begin; i < end; ++i) {
      const auto& match = matches[i - begin];
      if (match) factors[i] = make_factor(*match, bundles_sensor[i].count);
    }
  });
  return factors;
}

/// The equations of all factors, joined in order.
NormalEquations linearize(const Factors& factors, const std::vector<Gaussian>& bundles_sensor,
                          const Pose& T_map_sensor, const RobustKernel& kernel) {
  std::vector<NormalEquations> sums(chunks(factors.size(), kChunk));
  for_each_chunk(factors.size(), kChunk, [&](std::size_t chunk, std::size_t begin, std::size_t end) {
    for (std::size_t i = begin; i < end; ++i) {
      if (!factors[i]) continue;
      const Eigen::Vector3d from_sensor = T_map_sensor.rotation * bundles_sensor[i].mean;
      factors[i]->add_to(sums[chunk], T_map_sensor.translation + from_sensor, from_sensor, kernel);
    }
  });
  NormalEquations total;
  for (const NormalEquations& sum : sums) total += sum;
  return total;
}

/// Whether a pose has moved so far that bundles may belong to other leaves.
bool is_far(const Twist& since_matched) {
  constexpr double kTranslation = 0.003;  // [m]
  constexpr double kRotation = 3e-4;      // [rad]
  return since_matched.head<3>().norm() > kTranslation || since_matched.tail<3>().norm() > kRotation;
}

/// Of more than `count` bundles as many, evenly spread.
std::vector<Gaussian> thinned(const std::vector<Gaussian>& bundles, std::size_t count) {
  if (bundles.size() <= count) return bundles;
  std::vector<Gaussian> some;
  some.reserve(count);
  for (std::size_t i = 0; i < count; ++i) some.push_back(bundles[i * bundles.size() / count]);
  return some;
}

/// Moves the pose by one Gauss-Newton step, and returns it.
Twist move(Registration& at, const NormalEquations& equations, double damping) {
  Twist step = solve(equations, damping);
  at.T_map_sensor = perturb(at.T_map_sensor, step);
  ++at.iterations;
  return step;
}

/// Matches and moves until the pose rests under the narrow kernel; false when it does not.
bool search(Registration& at, const Octree& map, const std::vector<Gaussian>& bundles_sensor,
            const RegistrationParameters& parameters) {
  RobustKernel kernel{parameters.first_kernel_width};
  Factors factors;
  Pose T_map_matched;
  bool settled = false;
  while (!settled && at.iterations < parameters.termination.max_iterations) {
    if (factors.empty() || is_far(difference(T_map_matched, at.T_map_sensor))) {
      T_map_matched = at.T_map_sensor;
      factors = match(map, bundles_sensor, T_map_matched);
    }
    const NormalEquations equations = linearize(factors, bundles_sensor, at.T_map_sensor, kernel);
    const Twist step = move(at, equations, parameters.damping);
    settled = kernel.width == parameters.last_kernel_width && parameters.termination.is_settled(step);
    kernel.width = std::max(kernel.width / 2, parameters.last_kernel_width);
  }
  return settled;
}

/// Moves by the last millimetres. Returns the equations of the last step.
NormalEquations refine(Registration& at, const Octree& map, const std::vector<Gaussian>& bundles_sensor,
                       const RegistrationParameters& parameters) {
  constexpr int kSteps = 2;  // weighed anew in each; a third gains 3 %
  const RobustKernel kernel{parameters.last_kernel_width};
  const Factors factors = match(map, bundles_sensor, at.T_map_sensor);
  NormalEquations equations;
  for (int i = 0; i < kSteps; ++i) {
    equations = linearize(factors, bundles_sensor, at.T_map_sensor, kernel);
    move(at, equations, parameters.damping);
  }
  return equations;
}

double root_mean_square_range(const std::vector<Gaussian>& bundles_sensor) {
  double sum = 0;
  for (const Gaussian& bundle : bundles_sensor) sum += bundle.mean.squaredNorm();
  return std::sqrt(sum / static_cast<double>(bundles_sensor.size()));
}

RejectReason judge(const Registration& registration, std::size_t matched, bool settled,
                   const RegistrationParameters& parameters) {
  if (matched < parameters.least_matches) return RejectReason::kTooFewMatches;
  if (registration.inlier_fraction < parameters.least_inlier_fraction) return RejectReason::kTooFewInliers;
  if (registration.weakest.fraction < parameters.least_observability) return RejectReason::kUnobservable;
  return settled ? RejectReason::kNone : RejectReason::kNoConvergence;
}

}  // namespace

std::vector<Gaussian> bundles_in_sensor_frame(const Scan& scan, double edge, const LidarParameters& lidar,
                                              std::size_t max_bundles) {
  const VoxelGrid grid{.edge = std::max(edge, kLeastBundleEdge)};
  const BundleGrid condensed = condense(scan, Pose{}, grid, lidar, max_bundles);
  std::vector<Gaussian> bundles;
  bundles.reserve(condensed.bundles().size());
  for (const RayBundle& bundle : condensed.bundles()) bundles.push_back(bundle.points);
  return bundles;
}

Registration register_bundles(const Octree& map, const std::vector<Gaussian>& bundles_sensor,
                              const Pose& T_map_sensor_guess, const RegistrationParameters& parameters) {
  Registration result;
  result.T_map_sensor = T_map_sensor_guess;
  if (bundles_sensor.size() < parameters.least_matches) return result;
  const bool settled = search(result, map, thinned(bundles_sensor, parameters.first_bundles), parameters);
  const NormalEquations equations = refine(result, map, bundles_sensor, parameters);
  result.weakest = observability(equations.hessian, root_mean_square_range(bundles_sensor));
  result.inlier_fraction =
      static_cast<double>(equations.inliers) / static_cast<double>(bundles_sensor.size());
  result.residual = equations.inlier_error / std::max(1.0, static_cast<double>(equations.inliers));
  result.reject_reason = judge(result, equations.matched, settled, parameters);
  if (result.converged()) result.covariance = equations.hessian.inverse() * result.residual;
  return result;
}

Registration register_coarse_to_fine(const Octree& map, const Scan& scan, const Pose& T_map_sensor_guess,
                                     const LidarParameters& lidar, const RegistrationParameters& parameters) {
  Pose T_map_sensor = T_map_sensor_guess;
  const std::vector<Octree> views = coarse_views(map, T_map_sensor.translation);
  for (auto view = views.rbegin(); view != views.rend(); ++view) {
    const auto bundles = bundles_in_sensor_frame(scan, view->grid().edge, lidar, parameters.first_bundles);
    T_map_sensor = register_bundles(*view, bundles, T_map_sensor, parameters).T_map_sensor;
  }
  const auto bundles = bundles_in_sensor_frame(scan, map.grid().edge, lidar);
  return register_bundles(map, bundles, T_map_sensor, parameters);
}

}  // namespace evermap
