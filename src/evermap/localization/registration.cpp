// SPDX-FileCopyrightText: 2026 the evermap authors
// SPDX-License-Identifier: BSD-3-Clause
#include <algorithm>
#include <cmath>
#include <optional>
#include <span>

#include <Eigen/Eigenvalues>

#include <evermap/geometry/detail/for_each_index.hpp>
#include <evermap/geometry/detail/running_median.hpp>
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

/// A bundle on the map, if it is; what it says, unless it is a line.
struct Match {
  bool is_on_map = false;
  std::optional<Factor> factor = {};
};
using Matches = std::vector<Match>;  ///< one a bundle

Matches match(const Octree& map, const std::vector<Gaussian>& bundles_sensor, const Pose& T_map_sensor) {
  Matches matches(bundles_sensor.size());
  for_each_chunk(matches.size(), kChunk, [&](std::size_t, std::size_t begin, std::size_t end) {
    const auto found = correspond(map, std::span(bundles_sensor).subspan(begin, end - begin), T_map_sensor);
    for (std::size_t i = begin; i < end; ++i) {
      const auto& leaf = found[i - begin];
      if (leaf) matches[i] = {true, make_factor(*leaf, bundles_sensor[i].count)};
    }
  });
  return matches;
}

/// The sum of what `add(equations, i)` adds for each match, joined in order.
template <class Add>
NormalEquations sum_of(const Matches& matches, Add&& add) {
  std::vector<NormalEquations> sums(chunks(matches.size(), kChunk));
  for_each_chunk(matches.size(), kChunk, [&](std::size_t chunk, std::size_t begin, std::size_t end) {
    for (std::size_t i = begin; i < end; ++i) add(sums[chunk], i);
  });
  NormalEquations total;
  for (const NormalEquations& sum : sums) total += sum;
  return total;
}

NormalEquations linearize(const Matches& matches, const std::vector<Gaussian>& bundles_sensor,
                          const Pose& T_map_sensor, const RobustKernel& kernel) {
  return sum_of(matches, [&](NormalEquations& equations, std::size_t i) {
    const Gaussian& bundle = bundles_sensor[i];
    if (!matches[i].is_on_map) equations.asked += std::sqrt(bundle.count);
    if (!matches[i].factor) return;
    const Eigen::Vector3d from_sensor = T_map_sensor.rotation * bundle.mean;
    matches[i].factor->add_to(equations, T_map_sensor.translation + from_sensor, from_sensor, kernel);
  });
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
  Twist step = solve(equations, directions, damping);
  at.T_map_sensor = perturb(at.T_map_sensor, step);
  ++at.iterations;
  return step;
}

/// Matches and moves until the pose rests under the narrow kernel; false when it does not.
bool search(Registration& at, const Octree& map, const std::vector<Gaussian>& bundles_sensor,
            const Directions& directions, const RegistrationParameters& parameters) {
  RobustKernel kernel{parameters.first_kernel_width};
  Matches matches;
  Pose T_map_matched;
  bool settled = false;
  while (!settled && at.iterations < parameters.termination.max_iterations) {
    if (matches.empty() || is_far(difference(T_map_matched, at.T_map_sensor))) {
      T_map_matched = at.T_map_sensor;
      matches = match(map, bundles_sensor, T_map_matched);
    }
    const NormalEquations equations = linearize(matches, bundles_sensor, at.T_map_sensor, kernel);
    const Twist step = move(at, equations, directions, parameters.damping);
    settled = kernel.width == parameters.last_kernel_width && parameters.termination.is_settled(step);
    kernel.width = std::max(kernel.width / 2, parameters.last_kernel_width);
  }
  return settled;
}

/// Moves by how far bundles are off their leaves' planes, compared with one another: most by millimetres.
/// What is off by centimetres, though less than leaf and bundle are thick, has changed: a floor that was dug
/// away by little, a container that came back beside its place. All of that together draws poses to one side,
/// and the map after them.
void settle(Registration& at, const Matches& matches, const std::vector<Gaussian>& bundles_sensor,
            const Directions& directions, const RegistrationParameters& parameters) {
  constexpr int kSteps = 2;
  constexpr double kLeast = 0.001;           // [m] where the map was made of the same scan
  std::vector<double> offs(matches.size());  // [m]
  std::vector<double> distances;
  distances.reserve(matches.size());
  for (int step = 0; step < kSteps; ++step) {
    distances.clear();
    for (std::size_t i = 0; i < matches.size(); ++i) {
      if (!matches[i].factor) continue;
      const Correspondence& leaf = matches[i].factor->match;
      offs[i] = leaf.normal.dot(leaf.mean_leaf - at.T_map_sensor * bundles_sensor[i].mean);
      distances.push_back(std::abs(offs[i]));
    }
    if (distances.empty()) return;
    const auto middle = distances.begin() + static_cast<std::ptrdiff_t>(distances.size() / 2);
    std::nth_element(distances.begin(), middle, distances.end());
    const double sigma = std::max(kLeast, kMedianToSigma * *middle);
    const RobustKernel kernel{parameters.settling_width * sigma};
    const auto add = [&](NormalEquations& equations, std::size_t i) {
      if (!matches[i].factor) return;
      const Eigen::Vector3d from_sensor = at.T_map_sensor.rotation * bundles_sensor[i].mean;
      matches[i].factor->pull(equations, offs[i], from_sensor, kernel.weight(offs[i] * offs[i]));
    };
    move(at, sum_of(matches, add), directions, parameters.damping);
  }
}

/// Moves by the last millimetres. Returns the equations of the last step but those of settle().
NormalEquations refine(Registration& at, const Octree& map, const std::vector<Gaussian>& bundles_sensor,
                       const Directions& directions, const RegistrationParameters& parameters) {
  constexpr int kSteps = 2;  // weighed anew in each; a third gains 3 %
  const RobustKernel kernel{parameters.last_kernel_width};
  const Matches matches = match(map, bundles_sensor, at.T_map_sensor);
  NormalEquations equations;
  for (int i = 0; i < kSteps; ++i) {
    equations = linearize(matches, bundles_sensor, at.T_map_sensor, kernel);
    move(at, equations, directions, parameters.damping);
  }
  if (parameters.settling_width > 0) settle(at, matches, bundles_sensor, directions, parameters);
  return equations;
}

double root_mean_square_range(const std::vector<Gaussian>& bundles_sensor) {
  double sum = 0;
  for (const Gaussian& bundle : bundles_sensor) sum += bundle.mean.squaredNorm();
  return std::sqrt(sum / static_cast<double>(bundles_sensor.size()));
}

/// How far the scan, moved along `direction` by a good half of a leaf, is drawn back: 1, all the way; 0, it
/// fits there as well.
double response(const Octree& map, const std::vector<Gaussian>& bundles_sensor, const Pose& T_map_sensor,
                const Twist& direction, const RobustKernel& kernel) {
  double pull = 0;
  double stiffness = 0;
  for (const double leaves : {-0.75, -0.5, 0.5, 0.75}) {
    const Twist shift = leaves * map.grid().edge * direction;
    const Pose T_map_shifted = perturb(T_map_sensor, shift);
    const NormalEquations equations = equations_at(map, bundles_sensor, T_map_shifted, kernel);
    pull += shift.dot(equations.gradient);
    stiffness += shift.dot(equations.hessian * shift);
  }
  return stiffness > 0 ? pull / stiffness : 0;
}

/// What surfaces say about the pose. Noise tilts the normals of a wall, so that it seems to say something
/// along itself. Where little is said, the scan is therefore moved to where the noise is another: only what
/// draws it back is real.
Matrix6 information(const NormalEquations& equations, const Octree& map,
                    const std::vector<Gaussian>& bundles_sensor, const Pose& T_map_sensor,
                    const RegistrationParameters& parameters) {
  constexpr double kLittle = 0.05;  // of the mean direction's; endless corridors reach 0.02
  constexpr double kLeastResponse =
      0.2;                        // the ends of a corridor in sight draw by 0.26 or more, noise by 0.1
  constexpr double kVague = 0.1;  // [m] standard deviation: what says no more is not worth the doubt
  if (equations.inliers == 0) return Matrix6::Zero();
  const double lever = root_mean_square_range(bundles_sensor);
  const Twist units = (Twist() << 1, 1, 1, 1 / lever, 1 / lever, 1 / lever).finished();
  const Matrix6 scaled = units.asDiagonal() * equations.hessian * units.asDiagonal();
  const Eigen::SelfAdjointEigenSolver<Matrix6> eigen(scaled);
  const RobustKernel kernel{parameters.first_kernel_width};
  Twist real = eigen.eigenvalues().cwiseMax(0);
  for (int i = 0; i < 6 && real[i] < kLittle * eigen.eigenvalues().mean(); ++i) {
    const Twist direction = units.cwiseProduct(eigen.eigenvectors().col(i));
    const bool is_vague = equations.mean_inlier_error() > kVague * kVague * real[i];
    const bool is_real =
        !is_vague && response(map, bundles_sensor, T_map_sensor, direction, kernel) > kLeastResponse;
    if (!is_real) real[i] = 0;
  }
  const Matrix6 per_unit = eigen.eigenvectors() * real.asDiagonal() * eigen.eigenvectors().transpose();
  const Twist inverse = units.cwiseInverse();
  return inverse.asDiagonal() * per_unit * inverse.asDiagonal() / equations.mean_inlier_error();
}

/// Where few of a scan's bundles hold it (the ends of a corridor), it comes to rest at many places along that
/// direction: at a wall's other face, a shelf further on. The rest of the scan fits all of them alike, but
/// these few fit best where they belong. Looks along such directions, as far as the guess leaves them open.
/// Returns the place to search from, if another is better than where the scan is.
std::optional<Pose> place_along(const Registration& at, const NormalEquations& equations, const Octree& map,
                                const std::vector<Gaussian>& bundles_sensor, const Matrix6& covariance,
                                const RegistrationParameters& parameters) {
  constexpr double kStep = 0.1;   // [m] from farther, a thin surface is not noticed
  constexpr double kLeast = 0.2;  // [m] to either side: a guess may be wrong, too
  constexpr double kMost = 0.6;   // [m]
  constexpr double kSigmas = 3;
  constexpr double kFew = 0.1;  // of what holds it along the mean direction
  const Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d> eigen(equations.hessian.topLeftCorner<3, 3>());
  const RobustKernel kernel{parameters.last_kernel_width};
  std::optional<Pose> best;
  double best_fit = 0;
  for (int i = 0; i < 3 && eigen.eigenvalues()[i] < kFew * eigen.eigenvalues().mean(); ++i) {
    if (i == 0) best_fit = equations_at(map, bundles_sensor, at.T_map_sensor, kernel).fit();
    const Eigen::Vector3d direction = eigen.eigenvectors().col(i);
    const double sigma = std::sqrt(direction.dot(covariance.topLeftCorner<3, 3>() * direction));
    const int steps = static_cast<int>(std::clamp(kSigmas * sigma, kLeast, kMost) / kStep);
    for (int step = -steps; step <= steps; ++step) {
      if (step == 0) continue;
      Pose there = at.T_map_sensor;
      there.translation += step * kStep * direction;
      const double fit = equations_at(map, bundles_sensor, there, kernel).fit();
      if (fit <= best_fit) continue;
      best_fit = fit;
      best = there;
    }
  }
  return best;
}

RejectReason judge(const Registration& registration, std::size_t matched, bool settled,
                   const RegistrationParameters& parameters) {
  if (matched < parameters.least_matches) return RejectReason::kTooFewMatches;
  if (registration.inlier_fraction < parameters.least_inlier_fraction) return RejectReason::kTooFewInliers;
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

NormalEquations equations_at(const Octree& map, const std::vector<Gaussian>& bundles_sensor,
                             const Pose& T_map_sensor, const RobustKernel& kernel) {
  return linearize(match(map, bundles_sensor, T_map_sensor), bundles_sensor, T_map_sensor, kernel);
}

Registration register_bundles(const Octree& map, const std::vector<Gaussian>& bundles_sensor,
                              const PoseEstimate& guess, const RegistrationParameters& parameters) {
  Registration result;
  result.T_map_sensor = guess.T_map_sensor;
  result.covariance = guess.covariance;
  if (bundles_sensor.size() < parameters.least_matches) return result;
  const std::vector<Gaussian> first = thinned(bundles_sensor, parameters.first_bundles);
  Directions directions = Matrix6::Identity();
  bool settled = false;
  NormalEquations equations;
  const auto come_to_rest_from = [&](const Pose& T_map_sensor) {
    result.T_map_sensor = T_map_sensor;
    result.iterations = 0;
    settled = search(result, map, first, directions, parameters);
    equations = refine(result, map, bundles_sensor, directions, parameters);
  };
  come_to_rest_from(guess.T_map_sensor);
  if (const auto better = place_along(result, equations, map, first, guess.covariance, parameters))
    come_to_rest_from(*better);
  const Knowledge known =
      learn(information(equations, map, first, result.T_map_sensor, parameters), guess.covariance);
  if (known.directions.cols() < 6) {  // again, in these alone
    directions = known.directions;
    come_to_rest_from(guess.T_map_sensor);
  }
  result.covariance = known.covariance;
  result.unobservable = 6 - static_cast<int>(known.directions.cols());
  const auto matched = static_cast<double>(equations.matched);
  result.matched_fraction = matched / static_cast<double>(bundles_sensor.size());
  result.inlier_fraction = static_cast<double>(equations.inliers) / std::max(1.0, matched);
  result.fit = equations.fit();
  result.residual = equations.mean_inlier_error();
  result.reject_reason = judge(result, equations.matched, settled, parameters);
  return result;
}

CoarseToFine::CoarseToFine(const Octree& map, const Scan& scan, const Eigen::Vector3d& center_map,
                           const LidarParameters& lidar, const RegistrationParameters& parameters)
    : map_(&map), lidar_(lidar), parameters_(parameters), views_(coarse_views(map, center_map)) {
  set_scan(scan);
}

void CoarseToFine::set_scan(const Scan& scan) {
  bundles_ = bundles_in_sensor_frame(scan, map_->grid().edge, lidar_);
  wider_.clear();
  for (const Octree& view : views_) {
    wider_.push_back(bundles_in_sensor_frame(scan, view.grid().edge, lidar_, parameters_.first_bundles));
  }
}

Registration CoarseToFine::from(const PoseEstimate& guess, std::size_t views) const {
  Registration best;
  PoseEstimate known = guess;
  const auto go_on = [&](const Octree& view, const std::vector<Gaussian>& bundles) {
    const Registration next = register_bundles(view, bundles, known, parameters_);
    if (!next.converged() && best.converged()) return;
    best = next;
    known = {next.T_map_sensor, next.covariance + systematic(view.grid().edge)};
  };
  for (std::size_t i = std::min(views, views_.size()); i-- > 0;) go_on(views_[i], wider_[i]);
  go_on(*map_, bundles_);
  return best;
}

Registration register_coarse_to_fine(const Octree& map, const Scan& scan, const PoseEstimate& guess,
                                     const LidarParameters& lidar, const RegistrationParameters& parameters) {
  const CoarseToFine registration(map, scan, guess.T_map_sensor.translation, lidar, parameters);
  return registration.from(guess, registration.views());
}

double least_mapping_edge(const Scan& scan, const LidarParameters& lidar) {
  constexpr double kLeast = 0.8;  // [m]
  constexpr double kMost = 3.2;   // [m]
  constexpr double kLeastPatches = 0.25;
  const auto fraction_of_patches = [&](double edge) {
    double all = 0;
    double patches = 0;
    for (const Gaussian& bundle : bundles_in_sensor_frame(scan, edge, lidar)) {
      const Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d> eigen(bundle.covariance, Eigen::EigenvaluesOnly);
      const bool is_patch = bundle.count >= 4 && std::sqrt(eigen.eigenvalues()[1]) > edge / 12;
      all += std::sqrt(bundle.count);
      patches += is_patch ? std::sqrt(bundle.count) : 0;
    }
    return all > 0 ? patches / all : 1;
  };
  double edge = kLeast;
  while (edge < kMost && fraction_of_patches(edge) < kLeastPatches) edge *= 2;
  return edge;
}

}  // namespace evermap
