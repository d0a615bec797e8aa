// SPDX-FileCopyrightText: 2026 the evermap authors
// SPDX-License-Identifier: BSD-3-Clause
#include <algorithm>
#include <cmath>
#include <span>

#include <Eigen/LU>

#include <evermap/geometry/for_each_index.hpp>
#include <evermap/localization/coarse_map.hpp>
#include <evermap/localization/correspondence.hpp>
#include <evermap/localization/factor.hpp>
#include <evermap/localization/perturbation.hpp>
#include <evermap/localization/registration.hpp>
#include <evermap/localization/robust_kernel.hpp>
#include <evermap/localization/solver.hpp>

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
Twist move(Registration& at, const NormalEquations& equations, const Directions& directions, double damping) {
  const Twist step = solve(equations, directions, damping);
  at.T_map_sensor = perturb(at.T_map_sensor, step);
  ++at.iterations;
  return step;
}

/// Matches and moves until the pose rests under the narrow kernel; false when it does not.
bool search(Registration& at, const Octree& map, const std::vector<Gaussian>& bundles_sensor,
            const Directions& directions, const RegistrationParameters& parameters) {
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
    const Twist step = move(at, equations, directions, parameters.damping);
    settled = kernel.width == parameters.last_kernel_width && parameters.termination.is_settled(step);
    kernel.width = std::max(kernel.width / 2, parameters.last_kernel_width);
  }
  return settled;
}

/// What the last step was made of.
struct Refinement {
  Factors factors;
  NormalEquations equations;
};

/// Moves by the last millimetres.
Refinement refine(Registration& at, const Octree& map, const std::vector<Gaussian>& bundles_sensor,
                  const Directions& directions, const RegistrationParameters& parameters) {
  constexpr int kSteps = 2;  // weighed anew in each; a third gains 3 %
  const RobustKernel kernel{parameters.last_kernel_width};
  Refinement last{match(map, bundles_sensor, at.T_map_sensor), {}};
  for (int i = 0; i < kSteps; ++i) {
    last.equations = linearize(last.factors, bundles_sensor, at.T_map_sensor, kernel);
    move(at, last.equations, directions, parameters.damping);
  }
  return last;
}

/// What the factors say about the pose beyond what noise feigns; judged from some of them.
Matrix6 information(const Factors& factors, const std::vector<Gaussian>& bundles_sensor,
                    const Pose& T_map_sensor, const RobustKernel& kernel) {
  constexpr std::size_t kSamples = 1500;
  const std::size_t step = 1 + factors.size() / kSamples;
  std::vector<Matrix6> sums(chunks(chunks(factors.size(), step), kChunk), Matrix6::Zero());
  for_each_chunk(
      chunks(factors.size(), step), kChunk, [&](std::size_t chunk, std::size_t begin, std::size_t end) {
        for (std::size_t i = begin; i < end; ++i) {
          if (!factors[i * step]) continue;
          const Gaussian bundle = transform(T_map_sensor, bundles_sensor[i * step]);
          sums[chunk] +=
              factors[i * step]->information(bundle, bundle.mean - T_map_sensor.translation, kernel);
        }
      });
  Matrix6 total = Matrix6::Zero();
  for (const Matrix6& sum : sums) total += sum;
  return static_cast<double>(step) * total;
}

RejectReason judge(const Registration& registration, std::size_t matched, bool settled,
                   const RegistrationParameters& parameters) {
  if (matched < parameters.least_matches) return RejectReason::kTooFewMatches;
  if (registration.inlier_fraction < parameters.least_inlier_fraction) return RejectReason::kTooFewInliers;
  if (!settled) return RejectReason::kNoConvergence;
  return registration.observability.is_complete() ? RejectReason::kNone : RejectReason::kUnobservable;
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
  const std::vector<Gaussian> first = thinned(bundles_sensor, parameters.first_bundles);
  Directions directions = Matrix6::Identity();
  bool settled = search(result, map, first, directions, parameters);
  Refinement last = refine(result, map, bundles_sensor, directions, parameters);
  const RobustKernel kernel{parameters.last_kernel_width};
  result.observability = observability(information(last.factors, bundles_sensor, result.T_map_sensor, kernel),
                                       last.equations.noise(), parameters.accuracy);
  if (!result.observability.is_complete()) {  // again, in the others; in these the guess is all that is known
    directions = result.observability.directions.rightCols(6 - result.observability.unobservable);
    result.T_map_sensor = T_map_sensor_guess;
    result.iterations = 0;
    settled = search(result, map, first, directions, parameters);
    last = refine(result, map, bundles_sensor, directions, parameters);
  }
  const NormalEquations& equations = last.equations;
  const double matched = std::max(1.0, static_cast<double>(equations.matched));
  result.inlier_fraction = static_cast<double>(equations.inliers) / matched;
  result.matched_fraction = matched / static_cast<double>(bundles_sensor.size());
  result.residual = equations.inlier_error / std::max(1.0, static_cast<double>(equations.inliers));
  result.reject_reason = judge(result, equations.matched, settled, parameters);
  return result;
}

CoarseToFine::CoarseToFine(const Octree& map, const Scan& scan, const Eigen::Vector3d& center_map,
                           const LidarParameters& lidar, const RegistrationParameters& parameters,
                           double coarsest)
    : map_(map), parameters_(parameters), views_(coarse_views(map, center_map, coarsest)) {
  fine_ = bundles_in_sensor_frame(scan, map.grid().edge, lidar);
  for (const Octree& view : views_) {
    coarse_.push_back(bundles_in_sensor_frame(scan, view.grid().edge, lidar, parameters.first_bundles));
  }
}

Registration CoarseToFine::from(const Pose& T_map_sensor_guess, double coarsest) const {
  // Where single lines of points lie on the surfaces, their planes are seen in wide leaves only: what the
  // finer ones do not hold stays as the wider ones had it.
  Registration best;
  best.T_map_sensor = T_map_sensor_guess;
  const auto go_on = [&](const Octree& view, const std::vector<Gaussian>& bundles) {
    const Registration next = register_bundles(view, bundles, best.T_map_sensor, parameters_);
    if (!next.is_usable() && best.is_usable()) return;
    if (!best.is_usable() || next.observability.unobservable <= best.observability.unobservable) {
      best = next;
    } else {
      best.T_map_sensor = next.T_map_sensor;
    }
  };
  for (std::size_t i = views_.size(); i-- > 0;) {
    if (views_[i].grid().edge <= coarsest) go_on(views_[i], coarse_[i]);
  }
  go_on(map_, fine_);
  return best;
}

Registration register_coarse_to_fine(const Octree& map, const Scan& scan, const Pose& T_map_sensor_guess,
                                     const LidarParameters& lidar, const RegistrationParameters& parameters) {
  const CoarseToFine registration(map, scan, T_map_sensor_guess.translation, lidar, parameters);
  return registration.from(T_map_sensor_guess);
}

}  // namespace evermap
