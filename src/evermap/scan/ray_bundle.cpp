// SPDX-FileCopyrightText: 2026 the evermap authors
// SPDX-License-Identifier: BSD-3-Clause
#include <algorithm>
#include <bit>

#include <evermap/scan/ray_bundle.hpp>

namespace evermap {
namespace {

/// Moments of points about their voxel's centre, where coordinates are small and sums lose nothing.
struct Moments {
  VoxelKey key;
  Eigen::Vector3d center_map;
  Eigen::Vector3d sum = Eigen::Vector3d::Zero();
  Eigen::Matrix3d sum_of_squares = Eigen::Matrix3d::Zero();
  double count = 0;

  void add(const Eigen::Vector3d& p_map) {
    const Eigen::Vector3d p_voxel = p_map - center_map;
    sum += p_voxel;
    sum_of_squares.noalias() += p_voxel * p_voxel.transpose();
    ++count;
  }
};

RayBundle to_bundle(const Moments& m, double thickness) {
  constexpr double kPriorPoints = 2;  // n0: as much trust in the sensor's noise as in two points
  const Eigen::Vector3d mean = m.sum / m.count;
  const Eigen::Matrix3d scatter = m.sum_of_squares - m.count * mean * mean.transpose();
  const Eigen::Matrix3d prior = kPriorPoints * thickness * thickness * Eigen::Matrix3d::Identity();
  const Eigen::Matrix3d shrunk = (scatter + prior) / (m.count + kPriorPoints);
  return {m.key, {m.center_map + mean, floor_eigenvalues(shrunk, thickness * thickness / 4), m.count}};
}

}  // namespace

double least_thickness(const LidarParameters& lidar, const VoxelGrid& grid) {
  return std::max(lidar.range_sigma, 0.02 * grid.edge);
}

std::size_t BundleGrid::slot(VoxelKey key) const {
  const std::size_t mask = slots_.size() - 1;
  std::size_t at = hash_bits(key.bits()) & mask;
  while (slots_[at] != 0 && bundles_[slots_[at] - 1].key != key) at = (at + 1) & mask;
  return at;
}

const RayBundle* BundleGrid::find(VoxelKey key) const {
  if (bundles_.empty()) return nullptr;
  const std::uint32_t found = slots_[slot(key)];
  return found == 0 ? nullptr : &bundles_[found - 1];
}

BundleGrid condense(const Scan& scan, const Pose& T_map_sensor, const VoxelGrid& grid,
                    const LidarParameters& lidar) {
  BundleGrid result;
  result.origin_map = T_map_sensor.translation;
  result.slots_.assign(std::bit_ceil(2 * scan.p_sensor.size() + 2), 0);
  std::vector<Moments> moments;
  for (const Eigen::Vector3d& p_sensor : scan.p_sensor) {
    const double range = p_sensor.norm();
    if (range < lidar.min_range) {
      ++result.dropped_near;
      continue;
    }
    if (range > lidar.max_range) {
      ++result.dropped_far;
      continue;
    }
    const Eigen::Vector3d p_map = T_map_sensor * p_sensor;
    const auto key = grid.key(p_map);
    if (!key) {
      ++result.dropped_out_of_grid;
      continue;
    }
    std::uint32_t& found = result.slots_[result.slot(*key)];
    if (found == 0) {
      result.bundles_.push_back({*key, {}});
      moments.push_back({*key, grid.center(*key)});
      found = static_cast<std::uint32_t>(moments.size());
    }
    moments[found - 1].add(p_map);
  }
  const double thickness = least_thickness(lidar, grid);
  std::transform(moments.begin(), moments.end(), result.bundles_.begin(),
                 [&](const Moments& m) { return to_bundle(m, thickness); });
  return result;
}

}  // namespace evermap
