// SPDX-FileCopyrightText: 2026 the evermap authors
// SPDX-License-Identifier: BSD-3-Clause
#include <algorithm>
#include <cmath>
#include <optional>
#include <support/naive_walk.hpp>
#include <support/reference_update.hpp>
#include <vector>

#include <Eigen/Eigenvalues>
#include <Eigen/LU>

namespace evermap::test {
namespace {

using Eigen::Matrix3d;
using Eigen::Vector3d;
using Eigen::Vector3i;
using Eigensystem = Eigen::SelfAdjointEigenSolver<Matrix3d>;

constexpr double kQuantile95 = 7.814727903251179;
constexpr double kQuantile99 = 11.344866730144373;

struct Bundle {
  VoxelKey key;
  Vector3d mean;
  Matrix3d covariance;
  double count;
};

struct Contradiction {
  const Bundle* bundle;
  double impact;
};

double rounded(double x) { return static_cast<double>(static_cast<float>(x)); }

double squared_distance(const Vector3d& x, const Vector3d& mean, const Matrix3d& S) {
  return (x - mean).transpose() * S.inverse() * (x - mean);
}

Matrix3d floored(const Matrix3d& S, double least) {
  const Eigensystem eigen(S);
  const Matrix3d& V = eigen.eigenvectors();
  return V * eigen.eigenvalues().cwiseMax(least).asDiagonal() * V.transpose();
}

double thickness(const VoxelGrid& grid, const Parameters& parameters) {
  return std::max(parameters.lidar.range_sigma, 0.02 * grid.edge);
}

void store(ReferenceLeaf& leaf, const Vector3d& center) {
  leaf.mean = center + (leaf.mean - center).unaryExpr(&rounded);
  leaf.covariance = Matrix3d(leaf.covariance.selfadjointView<Eigen::Upper>()).unaryExpr(&rounded);
  leaf.count = rounded(leaf.count);
  leaf.log_odds = rounded(leaf.log_odds);
}

/// In ascending order of keys.
std::vector<Bundle> condensed(const Scan& scan, const Pose& T, const VoxelGrid& grid,
                              const Parameters& parameters) {
  std::map<VoxelKey, std::vector<Vector3d>> voxels;
  for (const Vector3d& p : scan.p_sensor) {
    if (p.norm() < parameters.lidar.min_range || p.norm() > parameters.lidar.max_range) continue;
    const Vector3d p_map = T.rotation * p + T.translation;
    const auto key = grid.key(p_map);
    if (!key) continue;
    voxels[*key].push_back(p_map);
  }
  const double s0 = thickness(grid, parameters);
  std::vector<Bundle> bundles;
  for (const auto& [key, points] : voxels) {
    const auto n = static_cast<double>(points.size());
    Vector3d mean = Vector3d::Zero();
    for (const Vector3d& p : points) mean += (p - points[0]) / n;
    mean += points[0];
    Matrix3d scatter = Matrix3d::Zero();
    for (const Vector3d& p : points) scatter += (p - mean) * (p - mean).transpose();
    const Matrix3d S = (scatter + 2 * s0 * s0 * Matrix3d::Identity()) / (n + 2);
    bundles.push_back({key, mean, floored(S, s0 * s0 / 4), n});
  }
  return bundles;
}

/// Equation 3: the positive root of 2 A t^2 + (T - 2 B) t - 3 = 0, at most 1.
double travel_time(const ReferenceLeaf& leaf, const Vector3d& o, const Bundle& bundle) {
  const Matrix3d P = leaf.covariance.inverse();
  const Vector3d d = bundle.mean - o;
  const long double A = d.dot(P * d);
  const long double B = d.dot(P * (leaf.mean - o));
  const long double T = (P * bundle.covariance).trace();
  return static_cast<double>(
      std::min(1.0L, (2 * B - T + std::sqrt((T - 2 * B) * (T - 2 * B) + 24 * A)) / (4 * A)));
}

/// Equations 3 to 5.
double paper_impact(const ReferenceLeaf& leaf, const Vector3d& o, const Bundle& bundle, double free,
                    ImpactRule rule) {
  const double t = travel_time(leaf, o, bundle);
  if (t * (bundle.mean - o).norm() > free) return 0;
  const Vector3d mean_t = o + t * (bundle.mean - o);
  const Matrix3d S_t = t * bundle.covariance;
  const Matrix3d P_V = leaf.covariance.inverse(), P_t = S_t.inverse();
  const Vector3d x_max = (P_V + P_t).inverse() * (P_V * (leaf.mean - mean_t)) + mean_t;
  if (squared_distance(x_max, leaf.mean, leaf.covariance) > kQuantile95) return 0;
  if (squared_distance(leaf.mean, mean_t, S_t) <= kQuantile95) return 1;
  const double longest = std::sqrt(Eigensystem(leaf.covariance).eigenvalues()[2]);
  const double apart = (leaf.mean - x_max).norm();
  if (rule == ImpactRule::kEquation5Printed) return std::min(1.0, apart / (2 * longest));
  return std::max(0.0, 1 - apart / (std::sqrt(kQuantile95) * longest));
}

/// What is known of a leaf and what is not: n points, and as many as extent_prior anywhere in the voxel,
/// though not off a flat leaf's plane.
Matrix3d extent(const ReferenceLeaf& leaf, const Eigensystem& eigen, bool flat, double edge,
                const UpdateParameters& parameters) {
  const double prior = parameters.extent_prior;
  Vector3d unseen = Vector3d::Constant(edge * edge / 12 * prior / (leaf.count + prior));
  if (flat) unseen[0] = 0;
  return leaf.covariance + eigen.eigenvectors() * unseen.asDiagonal() * eigen.eigenvectors().transpose();
}

double approach_impact(const ReferenceLeaf& leaf, double edge, const Vector3d& o, const Bundle& bundle,
                       double free, double error, const Parameters& parameters) {
  const Eigensystem eigen(leaf.covariance);
  const Vector3d n = eigen.eigenvectors().col(0);
  const bool flat = eigen.eigenvalues()[0] < 0.2 * eigen.eigenvalues()[1];
  const Vector3d u = (bundle.mean - o).normalized();
  const Matrix3d S = extent(leaf, eigen, flat, edge, parameters.update);
  const Matrix3d P = S.inverse();
  const double along = std::max(0.0, u.dot(P * (leaf.mean - o)) / u.dot(P * u));
  if (along > free) return 0;
  double squared = squared_distance(o + along * u, leaf.mean, S);
  if (flat)
    squared = std::max(0.0, squared - parameters.update.patch_radius * parameters.update.patch_radius);
  const double likelihood = std::exp(-squared / 2);
  if (likelihood < parameters.update.least_impact) return 0;
  const double length = (bundle.mean - o).norm();
  if (!(flat && parameters.update.surface_crossing) && length - along < parameters.update.hit_margin * error)
    return 0;
  if (!flat) return likelihood;
  const double side_o = n.dot(o - leaf.mean), side_end = n.dot(bundle.mean - leaf.mean);
  const bool through =
      (side_o < 0) != (side_end < 0) && std::abs(side_end) > 3 * std::sqrt(eigen.eigenvalues()[0]) +
                                                                 parameters.update.surface_tolerance * error;
  if (parameters.update.surface_crossing && !through) return 0;
  return likelihood;
}

bool is_hit(const std::vector<Bundle>& bundles, VoxelKey key) {
  return std::any_of(bundles.begin(), bundles.end(), [&](const Bundle& b) { return b.key == key; });
}

using Evidence = std::map<VoxelKey, std::vector<Contradiction>>;

Evidence gathered(const std::map<VoxelKey, ReferenceLeaf>& leaves, const std::vector<Bundle>& bundles,
                  const VoxelGrid& grid, const Vector3d& o, double error, const Parameters& parameters) {
  Evidence evidence;
  std::set<VoxelKey> hit;
  for (const Bundle& bundle : bundles) hit.insert(bundle.key);
  for (const Bundle& bundle : bundles) {
    const double length = (bundle.mean - o).norm();
    const Vector3d u = (bundle.mean - o) / length;
    const double sigma_along = std::sqrt(u.dot(bundle.covariance * u));
    const double free = length - (3 * parameters.lidar.range_sigma + 2 * sigma_along);
    const double paper_free = std::min(free, length - parameters.update.hit_margin * error);
    for (const NaiveStep& step : naive_walk(grid, {o, bundle.mean})) {
      if (free <= 0 || step.entry * length > free) break;
      const VoxelKey key = VoxelKey::from_voxel(step.voxel);
      const auto leaf = leaves.find(key);
      if (leaf == leaves.end() || key == bundle.key) continue;
      if (!parameters.update.trim_leaves && hit.contains(key)) continue;
      const double impact = parameters.update.impact == ImpactRule::kClosestApproach
                                ? approach_impact(leaf->second, grid.edge, o, bundle, free, error, parameters)
                                : paper_impact(leaf->second, o, bundle, paper_free, parameters.update.impact);
      if (impact > 0) evidence[key].push_back({&bundle, rounded(impact)});
    }
  }
  return evidence;
}

double combined(const std::vector<Contradiction>& contradictions, Combination combination) {
  double maximum = 0, spared = 1;
  for (const Contradiction& c : contradictions) {
    maximum = std::max(maximum, c.impact);
    spared *= 1 - c.impact;
  }
  return combination == Combination::kMaximum ? maximum : 1 - spared;
}

bool repeats(double a, double b, double scale) { return std::abs(a - b) < 1e-6 * scale; }

/// The scan's distance from the map: 1.4826 times the median distance of bundles of 3 and more points to the
/// planes of the occupied leaves of 10 and more points that they hit; 1 cm when fewer than 50 tell.
double alignment_error(const std::map<VoxelKey, ReferenceLeaf>& leaves, const std::vector<Bundle>& bundles) {
  std::vector<double> offsets;
  for (const Bundle& bundle : bundles) {
    const auto leaf = leaves.find(bundle.key);
    if (leaf == leaves.end() || leaf->second.log_odds <= 0) continue;
    if (leaf->second.count < 10 || bundle.count < 3) continue;
    const Eigensystem eigen(leaf->second.covariance);
    if (eigen.eigenvalues()[0] >= 0.2 * eigen.eigenvalues()[1]) continue;
    offsets.push_back(std::abs(eigen.eigenvectors().col(0).dot(bundle.mean - leaf->second.mean)));
  }
  if (offsets.size() < 50) return 0.01;
  std::sort(offsets.begin(), offsets.end());
  return 1.4826 * offsets[offsets.size() / 2];
}

/// Whether a neighbouring hit may be the leaf's own surface.
bool fits(const ReferenceLeaf& leaf, const Bundle& hit, double tolerance) {
  const Eigensystem own(leaf.covariance);
  Vector3d widths = Vector3d::Constant(tolerance);  // along the leaf's axes, the thinnest first
  if (own.eigenvalues()[0] < 0.2 * own.eigenvalues()[1]) widths[0] /= 3;
  const Matrix3d blur = own.eigenvectors() * widths.cwiseAbs2().asDiagonal() * own.eigenvectors().transpose();
  return squared_distance(leaf.mean, hit.mean, hit.covariance + blur) < kQuantile99;
}

/// Whether the leaf takes no miss.
bool is_spared(VoxelKey key, const ReferenceLeaf& leaf, const std::vector<Bundle>& bundles,
               bool spare_reobserved, double tolerance) {
  if (is_hit(bundles, key)) return true;
  return spare_reobserved && std::any_of(bundles.begin(), bundles.end(), [&](const Bundle& hit) {
           return (hit.key.voxel() - key.voxel()).cwiseAbs().maxCoeff() <= 1 && fits(leaf, hit, tolerance);
         });
}

/// Whether the ray goes, within an edge of the leaf, through the plane in which it and the occupied ones
/// around it lie together, if they do: fewer than 4, or such as fill their voxels, have none.
bool goes_through_surroundings(const std::map<VoxelKey, ReferenceLeaf>& leaves, VoxelKey key, double edge,
                               const Vector3d& o, const Vector3d& end) {
  std::vector<ReferenceLeaf> around;
  for (const auto& [near, leaf] : leaves) {
    if (leaf.log_odds > 0 && (near.voxel() - key.voxel()).cwiseAbs().maxCoeff() <= 1) around.push_back(leaf);
  }
  if (around.size() < 4) return true;
  const auto n = static_cast<double>(around.size());
  Vector3d mean = Vector3d::Zero();
  for (const ReferenceLeaf& leaf : around) mean += leaf.mean / n;
  Matrix3d S = Matrix3d::Zero();
  for (const ReferenceLeaf& leaf : around)
    S += (leaf.covariance + (leaf.mean - mean) * (leaf.mean - mean).transpose()) / n;
  const Eigensystem eigen(S);
  if (eigen.eigenvalues()[0] >= 0.2 * eigen.eigenvalues()[1]) return true;
  const Vector3d normal = eigen.eigenvectors().col(0);
  const Vector3d& middle = leaves.at(key).mean;
  const double side_o = normal.dot(o - middle), side_end = normal.dot(end - middle);
  const Vector3d crossing = o + side_o / (side_o - side_end) * (end - o);
  return (side_o < 0) != (side_end < 0) && (crossing - middle).norm() < edge;
}

/// Equation 6. Returns false when the outcome hangs on undetermined axes or on rounding.
bool subtract_sigma_points(ReferenceLeaf& leaf, const Vector3d& o, const Bundle& bundle) {
  const double t = travel_time(leaf, o, bundle);
  const Eigensystem eigen(leaf.covariance);
  std::vector<Vector3d> points{leaf.mean};
  for (int axis = 0; axis < 3; ++axis) {
    const Vector3d half_axis =
        std::sqrt(kQuantile95 * eigen.eigenvalues()[axis]) * eigen.eigenvectors().col(axis);
    points.emplace_back(leaf.mean + half_axis);
    points.emplace_back(leaf.mean - half_axis);
  }
  bool determined = true;
  std::vector<Vector3d> kept;
  for (const Vector3d& p : points) {
    const double squared = squared_distance(p, o + t * (bundle.mean - o), t * bundle.covariance);
    if (repeats(squared, kQuantile95, kQuantile95)) determined = false;
    if (squared > kQuantile95) kept.push_back(p);
  }
  const Vector3d& l = eigen.eigenvalues();
  if (repeats(l[0], l[1], l[2]) || repeats(l[1], l[2], l[2])) determined = false;
  if (kept.empty() || kept.size() == 7) return determined;
  const auto k = static_cast<double>(kept.size());
  Vector3d mean = Vector3d::Zero();
  for (const Vector3d& p : kept) mean += p / k;
  Matrix3d S = Matrix3d::Zero();
  for (const Vector3d& p : kept) S += (p - mean) * (p - mean).transpose() / k;
  leaf.mean = mean;
  leaf.covariance = S * 7 / (2 * kQuantile95);
  leaf.count *= k / 7;
  return determined;
}

/// A known leaf keeps what a hit confirms: a flat one its plane, another one all of its shape.
void keep_settled(ReferenceLeaf& leaf, const ReferenceLeaf& old, const Bundle& bundle, double error,
                  double settled) {
  const Eigensystem eigen(old.covariance);
  const double bound = settled * settled;
  if (eigen.eigenvalues()[0] >= 0.2 * eigen.eigenvalues()[1]) {
    if (squared_distance(bundle.mean, old.mean, old.covariance) >= bound) return;
    leaf.mean = old.mean;
    leaf.covariance = old.covariance;
    return;
  }
  const Matrix3d& axes = eigen.eigenvectors();  // the plane's normal first
  const double across = eigen.eigenvalues()[0];
  const Matrix3d hit = axes.transpose() * bundle.covariance * axes;
  const Vector3d apart = axes.transpose() * (bundle.mean - old.mean);
  const double noise = error * error + across / old.count + hit(0, 0) / bundle.count;
  if (apart[0] * apart[0] > bound * noise) return;
  Vector3d moved = axes.transpose() * (leaf.mean - old.mean);
  moved[0] = 0;
  Matrix3d shape = axes.transpose() * leaf.covariance * axes;
  shape.row(0).setZero();
  shape.col(0).setZero();
  shape(0, 0) = across;
  leaf.mean = old.mean + axes * moved;
  leaf.covariance = axes * shape * axes.transpose();
}

/// Each leaf that went takes from the flat ones around it that were not hit and before which it did not
/// stand.
void let_go_together(std::map<VoxelKey, ReferenceLeaf>& leaves, std::vector<VoxelKey> gone,
                     const std::vector<Bundle>& bundles, const VoxelGrid& grid, const Vector3d& o,
                     const UpdateParameters& parameters) {
  const auto around = [&](VoxelKey center) {
    std::vector<VoxelKey> keys;
    for (int z = -1; z <= 1; ++z)
      for (int y = -1; y <= 1; ++y)
        for (int x = -1; x <= 1; ++x) {
          const auto found = leaves.find(VoxelKey::from_voxel(center.voxel() + Vector3i(x, y, z)));
          if (found != leaves.end() && found->second.log_odds > 0) keys.push_back(found->first);
        }
    return keys;
  };
  while (!gone.empty()) {
    const VoxelKey went = gone.back();
    gone.pop_back();
    for (const VoxelKey key : around(went)) {
      if (is_hit(bundles, key)) continue;
      ReferenceLeaf& leaf = leaves.at(key);
      const Eigensystem eigen(leaf.covariance);
      if (eigen.eigenvalues()[0] >= 0.2 * eigen.eigenvalues()[1]) continue;
      const Vector3d n = eigen.eigenvectors().col(0);
      const double towards_sensor = n.dot(o - leaf.mean) > 0 ? 1 : -1;
      if (towards_sensor * n.dot(grid.center(went) - leaf.mean) > grid.edge / 2) continue;
      const auto left = static_cast<double>(around(key).size());
      leaf.log_odds = rounded(leaf.log_odds - rounded(parameters.cohesion / left * parameters.miss));
      if (leaf.log_odds > 0) continue;
      leaves.erase(key);
      gone.push_back(key);
    }
  }
}

/// Equation 7, the union, and one step up.
void confirm(std::map<VoxelKey, ReferenceLeaf>& leaves, const Bundle& bundle, const VoxelGrid& grid,
             const Parameters& parameters, int confirmations, double error, double settled) {
  const auto found = leaves.find(bundle.key);
  ReferenceLeaf leaf{bundle.mean, bundle.covariance, bundle.count,
                     parameters.update.hit * (2 - confirmations)};
  if (found != leaves.end()) {
    const ReferenceLeaf& old = found->second;
    const double n = old.count + bundle.count;
    const Vector3d mean = old.mean + bundle.count / n * (bundle.mean - old.mean);
    const auto about = [&](const Vector3d& m) { return Matrix3d((m - mean) * (m - mean).transpose()); };
    leaf = {mean,
            (old.count * (old.covariance + about(old.mean)) +
             bundle.count * (bundle.covariance + about(bundle.mean))) /
                n,
            n, old.log_odds + parameters.update.hit};
    if (settled > 0 && old.log_odds >= rounded(parameters.update.max_log_odds))
      keep_settled(leaf, old, bundle, error, settled);
    if (old.log_odds >= parameters.update.max_log_odds) {
      const double most = std::max(parameters.update.long_term_max_log_odds, parameters.update.max_log_odds);
      leaf.log_odds = std::min(old.log_odds + parameters.update.long_term_hit, most);
    } else {
      leaf.log_odds = std::min(leaf.log_odds, parameters.update.max_log_odds);
    }
  }
  leaf.count = std::min(leaf.count, parameters.update.max_count);
  store(leaf, grid.center(bundle.key));
  leaves[bundle.key] = leaf;
}

}  // namespace

void ReferenceUpdate::add(const Scan& scan, const Pose& T_map_sensor, const Parameters& parameters) {
  ambiguous.clear();
  for (const Bundle& bundle : condensed(scan, T_map_sensor, grid_, parameters)) {
    confirm(leaves, bundle, grid_, parameters, 1, 0, 0);
  }
}

void ReferenceUpdate::update(const Scan& scan, const Pose& T_map_sensor, const Parameters& parameters) {
  ambiguous.clear();
  const Vector3d o = T_map_sensor.translation;
  const auto bundles = condensed(scan, T_map_sensor, grid_, parameters);
  const double s0 = thickness(grid_, parameters);
  const double error = alignment_error(leaves, bundles);
  const double tolerance = parameters.update.surface_tolerance * error;
  Evidence evidence = gathered(leaves, bundles, grid_, o, error, parameters);
  for (auto& [key, contradictions] : evidence) {
    const Eigensystem own(leaves.at(key).covariance);
    const bool flat = own.eigenvalues()[0] < 0.2 * own.eigenvalues()[1];
    if (flat || !parameters.update.surface_crossing) continue;
    for (Contradiction& c : contradictions)
      if (!goes_through_surroundings(leaves, key, grid_.edge, o, c.bundle->mean)) c.impact = 0;
  }
  std::vector<VoxelKey> gone;
  for (const auto& [key, contradictions] : evidence) {
    ReferenceLeaf& leaf = leaves.at(key);
    const bool spared = is_spared(key, leaf, bundles, parameters.update.spare_reobserved, tolerance);
    for (const Contradiction& c : contradictions) {
      if (!parameters.update.trim_leaves) break;
      if (!subtract_sigma_points(leaf, o, *c.bundle)) ambiguous.insert(key);
      leaf.covariance = floored(leaf.covariance, s0 * s0 / 4);
    }
    store(leaf, grid_.center(key));
    if (spared) continue;
    const bool was_occupied = leaf.log_odds > 0;
    const double impact = combined(contradictions, parameters.update.combination);
    leaf.log_odds = rounded(leaf.log_odds - impact * parameters.update.miss);
    if (leaf.count > 1)
      leaf.count = rounded(std::max(1.0, leaf.count * (1 - impact * parameters.update.forgetting)));
    const double least = rounded(parameters.update.hit * (2 - parameters.update.confirmations));
    const bool goes = was_occupied ? leaf.log_odds <= 0 : leaf.log_odds < least;
    if (goes && was_occupied) gone.push_back(key);
    if (goes) leaves.erase(key);
  }
  if (parameters.update.cohesion > 0) let_go_together(leaves, gone, bundles, grid_, o, parameters.update);
  for (const Bundle& bundle : bundles)
    confirm(leaves, bundle, grid_, parameters, parameters.update.confirmations, error,
            parameters.update.settled);
}

}  // namespace evermap::test
