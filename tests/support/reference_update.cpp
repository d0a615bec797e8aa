// SPDX-FileCopyrightText: 2026 the evermap authors
// SPDX-License-Identifier: BSD-3-Clause
#include <algorithm>
#include <array>
#include <cmath>
#include <optional>
#include <support/naive_walk.hpp>
#include <support/reference_update.hpp>
#include <utility>
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

/// How far a scan is off: by its place [m], and by its direction [rad] the more the farther away.
struct AlignmentError {
  double position, direction;
  double at(double range) const {
    return std::sqrt(position * position + direction * direction * range * range);
  }
};

bool is_flat(const Eigensystem& eigen) { return eigen.eigenvalues()[0] < 0.2 * eigen.eigenvalues()[1]; }

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
  const bool flat = is_flat(eigen);
  const bool crosses = flat && parameters.update.surface_crossing;
  const Vector3d u = (bundle.mean - o).normalized();
  const Matrix3d S = extent(leaf, eigen, flat, edge, parameters.update);
  const Matrix3d P = S.inverse();
  double along = std::max(0.0, u.dot(P * (leaf.mean - o)) / u.dot(P * u));
  if (crosses) {
    const double side_o = n.dot(o - leaf.mean), side_end = n.dot(bundle.mean - leaf.mean);
    const double beyond = 3 * std::sqrt(eigen.eigenvalues()[0]) + parameters.update.surface_tolerance * error;
    if ((side_o < 0) == (side_end < 0) || std::abs(side_end) <= beyond) return 0;
    along = -side_o / n.dot(u);
  }
  if (along > free) return 0;
  double squared = squared_distance(o + along * u, leaf.mean, S);
  if (flat)
    squared = std::max(0.0, squared - parameters.update.patch_radius * parameters.update.patch_radius);
  const double likelihood = std::exp(-squared / 2);
  if (likelihood < parameters.update.least_impact) return 0;
  const double length = (bundle.mean - o).norm();
  if (!crosses && length - along < parameters.update.hit_margin * error) return 0;
  return likelihood;
}

bool is_hit(const std::vector<Bundle>& bundles, VoxelKey key) {
  return std::any_of(bundles.begin(), bundles.end(), [&](const Bundle& b) { return b.key == key; });
}

using Evidence = std::map<VoxelKey, std::vector<Contradiction>>;

Evidence gathered(const std::map<VoxelKey, ReferenceLeaf>& leaves, const std::vector<Bundle>& bundles,
                  const VoxelGrid& grid, const Vector3d& o, const AlignmentError& alignment,
                  const Parameters& parameters) {
  Evidence evidence;
  std::set<VoxelKey> hit;
  for (const Bundle& bundle : bundles) hit.insert(bundle.key);
  for (const Bundle& bundle : bundles) {
    const double length = (bundle.mean - o).norm();
    const Vector3d u = (bundle.mean - o) / length;
    const double sigma_along = std::sqrt(u.dot(bundle.covariance * u));
    const double free = length - (3 * parameters.lidar.range_sigma + 2 * sigma_along);
    for (const NaiveStep& step : naive_walk(grid, {o, bundle.mean})) {
      if (free <= 0 || step.entry * length > free) break;
      const VoxelKey key = VoxelKey::from_voxel(step.voxel);
      const auto leaf = leaves.find(key);
      if (leaf == leaves.end() || key == bundle.key) continue;
      if (!parameters.update.trim_leaves && hit.contains(key)) continue;
      const double error = alignment.at((leaf->second.mean - o).norm());
      const double paper_free = std::min(free, length - parameters.update.hit_margin * error);
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

double median(std::vector<double> values) {
  std::sort(values.begin(), values.end());
  return values[values.size() / 2];
}

/// The scan's distance from the map: 1.4826 times the median distance of bundles of 3 and more points to the
/// planes of the occupied leaves of 10 and more points that they hit; 1 cm when fewer than 50 tell. Where 100
/// tell, the nearer and the farther half each have one, at their median ranges, and what grows with the
/// square of the range is the error of the direction.
AlignmentError alignment_error(const std::map<VoxelKey, ReferenceLeaf>& leaves,
                               const std::vector<Bundle>& bundles, const Vector3d& o) {
  std::vector<std::pair<double, double>> offsets;  // range, distance
  for (const Bundle& bundle : bundles) {
    const auto leaf = leaves.find(bundle.key);
    if (leaf == leaves.end() || leaf->second.log_odds <= 0) continue;
    if (leaf->second.count < 10 || bundle.count < 3) continue;
    const Eigensystem eigen(leaf->second.covariance);
    if (!is_flat(eigen)) continue;
    offsets.emplace_back((bundle.mean - o).norm(),
                         std::abs(eigen.eigenvectors().col(0).dot(bundle.mean - leaf->second.mean)));
  }
  if (offsets.size() < 50) return {0.01, 0};
  std::sort(offsets.begin(), offsets.end());
  std::array<std::vector<double>, 2> ranges, distances;
  for (std::size_t i = 0; i < offsets.size(); ++i) {
    const std::size_t half = offsets.size() >= 100 && i >= offsets.size() / 2 ? 1 : 0;
    ranges[half].push_back(offsets[i].first);
    distances[half].push_back(offsets[i].second);
  }
  const double near = 1.4826 * median(distances[0]);
  if (offsets.size() < 100) return {near, 0};
  const double far = 1.4826 * median(distances[1]);
  const double r = median(ranges[0]), R = median(ranges[1]);
  const double slope = std::max(0.0, far * far - near * near) / std::max(1e-6, R * R - r * r);
  return {std::sqrt(std::max(0.0, near * near - slope * r * r)), std::sqrt(slope)};
}

/// Whether a neighbouring hit may be the leaf's own surface.
bool fits(const ReferenceLeaf& leaf, const Bundle& hit, double tolerance) {
  const Eigensystem own(leaf.covariance);
  Vector3d widths = Vector3d::Constant(tolerance);  // along the leaf's axes, the thinnest first
  if (is_flat(own)) widths[0] /= 3;
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

std::vector<ReferenceLeaf> occupied_around(const std::map<VoxelKey, ReferenceLeaf>& leaves, VoxelKey key,
                                           bool with_itself) {
  std::vector<ReferenceLeaf> around;
  for (int z = -1; z <= 1; ++z)
    for (int y = -1; y <= 1; ++y)
      for (int x = -1; x <= 1; ++x) {
        const auto found = leaves.find(VoxelKey::from_voxel(key.voxel() + Vector3i(x, y, z)));
        const bool is_itself = x == 0 && y == 0 && z == 0;
        if (found == leaves.end() || found->second.log_odds <= 0 || (is_itself && !with_itself)) continue;
        around.push_back(found->second);
      }
  return around;
}

/// The axes in which a leaf and the occupied ones around it lie together.
Eigensystem surroundings(const std::vector<ReferenceLeaf>& around) {
  const auto n = static_cast<double>(around.size());
  Vector3d mean = Vector3d::Zero();
  for (const ReferenceLeaf& leaf : around) mean += leaf.mean / n;
  Matrix3d S = Matrix3d::Zero();
  for (const ReferenceLeaf& leaf : around)
    S += (leaf.covariance + (leaf.mean - mean) * (leaf.mean - mean).transpose()) / n;
  return Eigensystem(S);
}

/// Whether the ray goes, within an edge of the leaf, through the plane in which it and the occupied ones
/// around it lie together, if they do: fewer than 4, or such as fill their voxels, have none. If they do not,
/// and those that are flat make a corner in the leaf, whether the ray goes through one of their planes there
/// and ends beyond.
bool goes_through_surroundings(const std::map<VoxelKey, ReferenceLeaf>& leaves, VoxelKey key, double edge,
                               const Vector3d& o, const Vector3d& end, double tolerance) {
  const Vector3d& middle = leaves.at(key).mean;
  const auto goes_through = [&](const Vector3d& normal, const Vector3d& on_plane) {
    const double side_o = normal.dot(o - on_plane), side_end = normal.dot(end - on_plane);
    const Vector3d crossing = o + side_o / (side_o - side_end) * (end - o);
    return (side_o < 0) != (side_end < 0) && (crossing - on_plane).norm() < edge;
  };
  const std::vector<ReferenceLeaf> around = occupied_around(leaves, key, true);
  if (around.size() >= 4) {
    const Eigensystem eigen = surroundings(around);
    if (is_flat(eigen)) return goes_through(eigen.eigenvectors().col(0), middle);
  }
  std::vector<Vector3d> normals;
  bool is_corner = false, is_through = false;
  for (const ReferenceLeaf& near : occupied_around(leaves, key, false)) {
    const Eigensystem eigen(near.covariance);
    const Vector3d normal = eigen.eigenvectors().col(0);
    const double apart = normal.dot(middle - near.mean);
    if (!is_flat(eigen) || std::abs(apart) > edge / 2) continue;
    normals.push_back(normal);
    if (std::abs(normal.dot(normals.front())) < 0.7) is_corner = true;
    const double beyond = std::abs(normal.dot(end - near.mean));
    if (beyond > 3 * std::sqrt(eigen.eigenvalues()[0]) + tolerance &&
        goes_through(normal, middle - apart * normal))
      is_through = true;
  }
  return !is_corner || is_through;
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
  if (!is_flat(eigen)) {
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

/// Removes the regions of surface beside what went that nothing holds, and those beside them, and so on.
void remove_regions(std::map<VoxelKey, ReferenceLeaf>& leaves, std::vector<VoxelKey> went,
                    const std::vector<Bundle>& bundles, const VoxelGrid& grid, const Vector3d& o,
                    const UpdateParameters& parameters) {
  struct Surface {
    Vector3d mean, normal;
    bool flat;
  };
  const auto around = [](VoxelKey center) {
    std::vector<VoxelKey> keys;
    for (int i = 0; i < 27; ++i)
      if (i != 13)
        keys.push_back(
            VoxelKey::from_voxel(center.voxel() + Vector3i(i % 3, i / 3 % 3, i / 9) - Vector3i::Ones()));
    return keys;
  };
  const auto occupied = [&](VoxelKey key) {
    const auto found = leaves.find(key);
    return found != leaves.end() && found->second.log_odds > 0;
  };
  const auto surface_at = [&](VoxelKey key) -> Surface {
    const ReferenceLeaf& leaf = leaves.at(key);
    const Eigensystem own(leaf.covariance);
    if (is_flat(own) || is_hit(bundles, key)) return {leaf.mean, own.eigenvectors().col(0), is_flat(own)};
    const std::vector<ReferenceLeaf> near = occupied_around(leaves, key, true);
    if (near.size() < 4) return {leaf.mean, Vector3d::Zero(), false};
    const Eigensystem joint = surroundings(near);
    return {leaf.mean, joint.eigenvectors().col(0), is_flat(joint)};
  };
  const auto before = [&](const Surface& s, const Vector3d& p) {
    const double side = s.normal.dot(p - s.mean);
    return !s.flat || (s.normal.dot(o - s.mean) > 0 ? side : -side) > grid.edge / 2;
  };
  const auto coherent = [&](const Surface& a, const Surface& b) {
    const Vector3d apart = b.mean - a.mean;
    return a.flat && b.flat && std::abs(a.normal.dot(b.normal)) >= 0.85 &&
           std::abs(a.normal.dot(apart)) <= grid.edge / 2 && std::abs(b.normal.dot(apart)) <= grid.edge / 2;
  };
  std::set<VoxelKey> gone;
  while (!went.empty()) {
    gone.insert(went.begin(), went.end());
    std::map<VoxelKey, Surface> surfaces;
    for (const auto& [key, leaf] : leaves)
      if (leaf.log_odds > 0) surfaces.emplace(key, surface_at(key));
    std::set<VoxelKey> going, done;
    for (const VoxelKey from : went) {
      const auto beside = around(from);
      if (std::count_if(beside.begin(), beside.end(), [&](VoxelKey near) { return gone.contains(near); }) < 3)
        continue;  // a small hole
      for (const VoxelKey start : beside) {
        if (!occupied(start) || is_hit(bundles, start) || done.contains(start)) continue;
        if (before(surfaces.at(start), grid.center(from))) continue;
        std::set<VoxelKey> region{start}, lost, held, rim, missing;
        std::vector<VoxelKey> open{start};
        while (!open.empty()) {
          const VoxelKey key = open.back();
          open.pop_back();
          const Surface& own = surfaces.at(key);
          int within = 0;
          for (const VoxelKey near : around(key)) {
            if (!occupied(near)) {
              if (!gone.contains(near) || before(own, grid.center(near))) continue;
              lost.insert(key);
              missing.insert(near);
            } else if (!is_hit(bundles, near) && coherent(own, surfaces.at(near))) {
              ++within;
              if (region.insert(near).second) open.push_back(near);
            } else if (is_hit(bundles, near) || leaves.at(near).log_odds > rounded(parameters.max_log_odds)) {
              const Surface& other = surfaces.at(near);
              if (!other.flat || !before(other, own.mean)) held.insert(key);
            }
          }
          if (within < 7) rim.insert(key);
        }
        done.insert(region.begin(), region.end());
        const auto count = [](const std::set<VoxelKey>& keys) { return static_cast<double>(keys.size()); };
        if (region.size() <= 1000 && held.size() <= 30 && missing.size() >= 4 &&
            count(lost) >= parameters.rim_gone * count(rim) && count(held) <= count(lost) / 4)
          going.insert(region.begin(), region.end());
      }
    }
    for (const VoxelKey key : going) leaves.erase(key);
    went.assign(going.begin(), going.end());
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
  const AlignmentError error = alignment_error(leaves, bundles, o);
  const auto tolerance_at = [&](VoxelKey key) {
    return parameters.update.surface_tolerance * error.at((leaves.at(key).mean - o).norm());
  };
  Evidence evidence = gathered(leaves, bundles, grid_, o, error, parameters);
  for (auto& [key, contradictions] : evidence) {
    const Eigensystem own(leaves.at(key).covariance);
    const bool flat = is_flat(own);
    if (flat || !parameters.update.surface_crossing) continue;
    for (Contradiction& c : contradictions)
      if (!goes_through_surroundings(leaves, key, grid_.edge, o, c.bundle->mean, tolerance_at(key)))
        c.impact = 0;
  }
  std::vector<VoxelKey> gone;
  for (const auto& [key, contradictions] : evidence) {
    ReferenceLeaf& leaf = leaves.at(key);
    const bool spared = is_spared(key, leaf, bundles, parameters.update.spare_reobserved, tolerance_at(key));
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
  if (parameters.update.rim_gone > 0) remove_regions(leaves, gone, bundles, grid_, o, parameters.update);
  for (const Bundle& bundle : bundles)
    confirm(leaves, bundle, grid_, parameters, parameters.update.confirmations,
            error.at((bundle.mean - o).norm()), parameters.update.settled);
}

}  // namespace evermap::test
