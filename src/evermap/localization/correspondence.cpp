// SPDX-FileCopyrightText: 2026 the evermap authors
// SPDX-License-Identifier: BSD-3-Clause
#include <algorithm>
#include <cmath>

#include <Eigen/LU>

#include <evermap/localization/detail/correspondence.hpp>
#include <evermap/map/detail/leaf_finder.hpp>

namespace evermap {
namespace {

/// How near to a face a bundle may belong beyond it although its own voxel holds a leaf; a fraction of the
/// edge.
constexpr double kNearFace = 0.2;

/// A leaf that a bundle may belong to.
struct Candidate {
  std::size_t bundle;
  Eigen::Vector3i voxel;
  const Leaf* leaf;
};

/// The step from a voxel across that of its two faces along `axis` which is nearer.
Eigen::Vector3i across(const Eigen::Vector3d& from_center, int axis) {
  return (from_center[axis] < 0 ? -1 : 1) * Eigen::Vector3i::Unit(axis);
}

/// The leaf of a voxel, which may lie beyond the grid; nullptr where there is none.
const Leaf* find(LeafFinder<const Octree>& leaves, const Eigen::Vector3i& voxel) {
  return VoxelKey::in_range(voxel) ? leaves.find(VoxelKey::from_voxel(voxel)) : nullptr;
}

/// The candidates of all bundles, in their order. Leaves lie all over the memory: all are asked for before
/// any is used.
std::vector<Candidate> candidates(const Octree& map, std::span<const Gaussian> bundles) {
  std::vector<Candidate> found;
  found.reserve(4 * bundles.size());
  LeafFinder finder(map);
  const auto ask = [&](std::size_t bundle, const Eigen::Vector3i& voxel) {
    const Leaf* leaf = find(finder, voxel);
    if (leaf == nullptr) return false;
    leaf->prefetch();
    found.push_back({bundle, voxel, leaf});
    return true;
  };
  for (std::size_t i = 0; i < bundles.size(); ++i) {
    const auto voxel = map.grid().voxel(bundles[i].mean);
    if (!voxel) continue;
    const double least = ask(i, *voxel) ? (0.5 - kNearFace) * map.grid().edge : 0;
    const Eigen::Vector3d from_center = bundles[i].mean - map.grid().center(*voxel);
    for (int axis = 0; axis < 3; ++axis) {
      if (std::abs(from_center[axis]) < least) continue;
      ask(i, *voxel + across(from_center, axis));
    }
  }
  return found;
}

/// The square of a symmetric matrix: symmetric, too, so that half of the products are enough.
Eigen::Matrix3d square(const Eigen::Matrix3d& S) {
  const double xx = S(0, 0), xy = S(1, 0), xz = S(2, 0), yy = S(1, 1), yz = S(2, 1), zz = S(2, 2);
  Eigen::Matrix3d squared;
  squared(0, 0) = xx * xx + xy * xy + xz * xz;
  squared(1, 1) = xy * xy + yy * yy + yz * yz;
  squared(2, 2) = xz * xz + yz * yz + zz * zz;
  squared(0, 1) = squared(1, 0) = xy * (xx + yy) + xz * yz;
  squared(0, 2) = squared(2, 0) = xz * (xx + zz) + xy * yz;
  squared(1, 2) = squared(2, 1) = yz * (yy + zz) + xy * xz;
  return squared;
}

/// How thick a leaf is along a direction [m].
double thickness(const Leaf& leaf, const Eigen::Vector3d& normal) {
  return std::sqrt(std::max(0.0, normal.dot(leaf.covariance_matrix() * normal)));
}

/// Whether a thick leaf is a piece of a wall whose faces both lie in it: leaves beside it, along each axis
/// that has any, are as thick, and in line with it. Where a wall meets the ground, or among leaves of trees,
/// they are not. A wall that is thicker than its leaves are long looks as if it stood across itself; but then
/// it goes on along the normal.
bool is_wall(LeafFinder<const Octree>& finder, const VoxelGrid& grid, const Correspondence& match,
             double thick) {
  constexpr double kInLine = 0.3;  // times the thickness
  constexpr int kLeast = 2;        // leaves beside it that tell
  const auto voxel = grid.voxel(match.mean_leaf);
  if (!voxel) return false;
  Eigen::Index across_wall = 0;
  match.normal.cwiseAbs().maxCoeff(&across_wall);
  int alike = 0;
  for (int axis = 0; axis < 3; ++axis) {
    int beside_axis = 0;
    int as_thick = 0;
    int alike_axis = 0;
    for (const int step : {-1, 1}) {
      const Eigen::Vector3i there = *voxel + step * Eigen::Vector3i::Unit(axis);
      const Leaf* leaf = find(finder, there);
      if (leaf == nullptr || !leaf->occupied()) continue;
      ++beside_axis;
      if (std::abs(thickness(*leaf, match.normal) - thick) > kInLine * thick) continue;
      ++as_thick;
      const double off = match.normal.dot(leaf->gaussian(grid.center(there)).mean - match.mean_leaf);
      if (std::abs(off) <= kInLine * thick) ++alike_axis;
    }
    if (axis == across_wall ? as_thick > 0 : beside_axis > 0 && alike_axis == 0) return false;
    alike += alike_axis;
  }
  return alike >= kLeast;
}

/// The far and the near face of a wall may lie in one leaf, whose Gaussian then is as thick as the wall, and
/// its mean in the middle of it. A bundle much thinner than its leaf shows one of two faces: as thick as the
/// bundle each, and so far from the mean that both together are as thick as the leaf. The sensor sees the
/// nearer one.
void choose_face(Correspondence& match, LeafFinder<const Octree>& finder, const VoxelGrid& grid,
                 const Leaf& leaf, const Gaussian& bundle, const Eigen::Vector3d& sensor_map) {
  constexpr double kThick = 0.125;  // of an edge: half of a wall's thickness, at least,
  constexpr double kPlate = 0.04;   // [m] or this, where leaves are large,
  constexpr double kMost = 0.2;     // [m] and at most
  constexpr double kThicker = 3;    // times the bundle's
  constexpr double kUnsure = 0.25;  // of the faces' offset: one may have more points than the other
  const Eigen::Vector3d& n = match.normal;
  const double thick = thickness(leaf, n);
  if (thick < std::min(kThick * grid.edge, kPlate) || thick > kMost) return;
  const double face = n.dot(bundle.covariance * n);
  if (thick * thick < kThicker * kThicker * face || !is_wall(finder, grid, match, thick)) return;
  const double offset = std::sqrt(thick * thick - face);
  match.mean_leaf += std::copysign(offset, n.dot(sensor_map - match.mean_leaf)) * n;
  const Eigen::Matrix3d within = Eigen::Matrix3d::Identity() - n * n.transpose();
  const double across = face + kUnsure * kUnsure * offset * offset;
  match.information =
      (within * leaf.covariance_matrix() * within + across * n * n.transpose() + bundle.covariance).inverse();
  const Eigen::Vector3d residual = match.mean_leaf - bundle.mean;
  match.mahalanobis_squared = residual.dot(match.information * residual);
}

/// Whether a face stands so close in front of this one that the sensor sees that one and never this: the far
/// face of a wall. Surveys show both.
bool is_hidden(LeafFinder<const Octree>& finder, const VoxelGrid& grid, const Leaf& leaf,
               const Correspondence& match, const Eigen::Vector3d& sensor_map) {
  constexpr int kReach = 2;          // voxels: as far as scans are drawn to the wrong face,
  constexpr double kWall = 0.4;      // [m] or a wall's thickness, where leaves are small
  constexpr double kThin = 1.0 / 8;  // of an edge: what is thicker along the normal lies across it
  constexpr double kSeparate = 4;    // times both thicknesses: else it is one surface, noise cut in two
  const double own = thickness(leaf, match.normal);
  if (own > kThin * grid.edge) return false;
  const double side = match.normal.dot(sensor_map - match.mean_leaf) < 0 ? -1 : 1;
  const Eigen::Vector3d towards = side * match.normal;
  const int reach = std::max(kReach, static_cast<int>(std::ceil(kWall / grid.edge)));
  for (int step = 1; step <= reach; ++step) {
    const auto voxel = grid.voxel(match.mean_leaf + step * grid.edge * towards);
    if (!voxel) return false;
    const Leaf* front = finder.find(VoxelKey::from_voxel(*voxel));
    if (front == nullptr || !front->occupied()) continue;
    const double thick = thickness(*front, match.normal);
    const double distance = towards.dot(front->gaussian(grid.center(*voxel)).mean - match.mean_leaf);
    if (thick < kThin * grid.edge && distance > kSeparate * (own + thick)) return true;
  }
  return false;
}

}  // namespace

Eigen::Vector3d stiffest_axis(const Eigen::Matrix3d& information) {
  // Powers of M turn towards its stiffest axis. All eigenvectors would take several times as long.
  Eigen::Matrix3d power = information / information.trace();  // so that the 24th lies between 1 and 3^-24
  for (int doubling = 0; doubling < 3; ++doubling) power = square(power);
  Eigen::Index column = 0;
  power.diagonal().maxCoeff(&column);
  return (power * (power * power.col(column))).normalized();
}

std::vector<std::optional<Correspondence>> correspond(const Octree& map,
                                                      std::span<const Gaussian> bundles_sensor,
                                                      const Pose& T_map_sensor) {
  std::vector<Gaussian> bundles;
  bundles.reserve(bundles_sensor.size());
  for (const Gaussian& bundle : bundles_sensor) bundles.push_back(transform(T_map_sensor, bundle));
  std::vector<std::optional<Correspondence>> matches(bundles.size());
  std::vector<const Leaf*> leaves(bundles.size());  // of the matches
  const auto consider = [&](std::size_t i, const Eigen::Vector3i& voxel, const Leaf& leaf) {
    if (!leaf.occupied()) return;
    std::optional<Correspondence>& best = matches[i];
    const Gaussian& bundle = bundles[i];
    const Eigen::Vector3d mean_leaf = leaf.gaussian(map.grid().center(voxel)).mean;
    const Eigen::Vector3d residual = mean_leaf - bundle.mean;
    const Eigen::Matrix3d covariance = leaf.covariance_matrix() + bundle.covariance;
    // No eigenvalue exceeds the trace, so this is the least that e' M e can be; it spares most inverses.
    if (best && residual.squaredNorm() >= best->mahalanobis_squared * covariance.trace()) return;
    const Eigen::Matrix3d information = covariance.inverse();
    const double mahalanobis_squared = residual.dot(information * residual);
    if (best && best->mahalanobis_squared <= mahalanobis_squared) return;
    const double occupancy = 1 / (1 + std::exp(-static_cast<double>(leaf.log_odds)));
    best = {mean_leaf, information, Eigen::Vector3d::Zero(), mahalanobis_squared, occupancy};
    leaves[i] = &leaf;
  };
  for (const auto& [i, voxel, leaf] : candidates(map, bundles)) consider(i, voxel, *leaf);
  LeafFinder finder(map);
  const auto is_seen = [&](std::size_t i) {
    matches[i]->normal = stiffest_axis(matches[i]->information);
    choose_face(*matches[i], finder, map.grid(), *leaves[i], bundles[i], T_map_sensor.translation);
    return !is_hidden(finder, map.grid(), *leaves[i], *matches[i], T_map_sensor.translation);
  };
  for (std::size_t i = 0; i < bundles.size(); ++i) {
    if (!matches[i] || is_seen(i)) continue;
    // A leaf that nobody sees does not keep the others away.
    const Leaf* hidden = leaves[i];
    matches[i].reset();
    const Eigen::Vector3i voxel = *map.grid().voxel(bundles[i].mean);
    const Eigen::Vector3d from_center = bundles[i].mean - map.grid().center(voxel);
    const auto consider_other = [&](const Eigen::Vector3i& there) {
      const Leaf* leaf = find(finder, there);
      if (leaf != nullptr && leaf != hidden) consider(i, there, *leaf);
    };
    consider_other(voxel);
    for (int axis = 0; axis < 3; ++axis) consider_other(voxel + across(from_center, axis));
    if (matches[i] && !is_seen(i)) matches[i].reset();
  }
  return matches;
}

}  // namespace evermap
