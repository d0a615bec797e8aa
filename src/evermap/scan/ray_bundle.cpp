// SPDX-FileCopyrightText: 2026 the evermap authors
// SPDX-License-Identifier: BSD-3-Clause
#include <algorithm>
#include <array>
#include <span>
#include <utility>

#include <evermap/geometry/for_each_index.hpp>
#include <evermap/scan/ray_bundle.hpp>

namespace evermap {
namespace {

constexpr std::size_t kGrain = 1024;  ///< points or bundles per task

enum class Use : std::uint8_t { kTaken, kNear, kFar, kOutOfGrid };

struct KeyedPoint {
  VoxelKey key;
  std::uint32_t index;  ///< in the scan
  Use use;
};

KeyedPoint key_of(const Eigen::Vector3d& p_sensor, std::uint32_t index, const Pose& T_map_sensor,
                  const VoxelGrid& grid, const LidarParameters& lidar) {
  const double range_squared = p_sensor.squaredNorm();
  if (range_squared < lidar.min_range * lidar.min_range) return {{}, index, Use::kNear};
  if (range_squared > lidar.max_range * lidar.max_range) return {{}, index, Use::kFar};
  const auto key = grid.key(T_map_sensor * p_sensor);
  if (!key) return {{}, index, Use::kOutOfGrid};
  return {*key, index, Use::kTaken};
}

/// Sorts by key; points of one key keep their order. (Radix sort, from the lowest digit up.)
void sort_by_key(std::vector<KeyedPoint>& points) {
  constexpr int kDigits = 6;
  constexpr int kBits = 11;
  constexpr std::size_t kBuckets = std::size_t{1} << kBits;
  const auto bucket = [](const KeyedPoint& point, int digit) {
    return static_cast<std::size_t>(point.key.bits() >> (digit * kBits)) & (kBuckets - 1);
  };
  std::vector<std::array<std::uint32_t, kBuckets>> begin(kDigits);  // first the sizes of the buckets
  for (const KeyedPoint& point : points) {
    for (int digit = 0; digit < kDigits; ++digit) {
      ++begin[static_cast<std::size_t>(digit)][bucket(point, digit)];
    }
  }
  std::vector<KeyedPoint> sorted(points.size());
  for (int digit = 0; digit < kDigits; ++digit) {
    auto& next = begin[static_cast<std::size_t>(digit)];
    if (next[bucket(points.front(), digit)] == points.size()) continue;  // all in one bucket
    std::uint32_t sum = 0;
    for (std::uint32_t& entry : next) sum += std::exchange(entry, sum);
    for (const KeyedPoint& point : points) sorted[next[bucket(point, digit)]++] = point;
    points.swap(sorted);
  }
}

RayBundle bundle_of(std::span<const KeyedPoint> points, const Scan& scan, const Pose& T_map_sensor,
                    const VoxelGrid& grid, double thickness) {
  // Moments about the voxel's centre, where coordinates are small and sums lose nothing; in scalars, since
  // the compiler keeps those in registers.
  const Eigen::Vector3d center_map = grid.center(points.front().key);
  double x = 0, y = 0, z = 0, xx = 0, xy = 0, xz = 0, yy = 0, yz = 0, zz = 0;
  for (const KeyedPoint& point : points) {
    const Eigen::Vector3d p = T_map_sensor * scan.p_sensor[point.index] - center_map;
    x += p.x(), y += p.y(), z += p.z();
    xx += p.x() * p.x(), xy += p.x() * p.y(), xz += p.x() * p.z();
    yy += p.y() * p.y(), yz += p.y() * p.z(), zz += p.z() * p.z();
  }
  constexpr double kPriorPoints = 2;  // n0: as much trust in the sensor's noise as in two points
  const auto count = static_cast<double>(points.size());
  const double prior = kPriorPoints * thickness * thickness;
  Eigen::Matrix3d S;
  S << xx - x * x / count + prior, xy - x * y / count, xz - x * z / count,  //
      xy - x * y / count, yy - y * y / count + prior, yz - y * z / count,   //
      xz - x * z / count, yz - y * z / count, zz - z * z / count + prior;
  const Eigen::Vector3d mean = center_map + Eigen::Vector3d(x, y, z) / count;
  S /= count + kPriorPoints;
  const double floor = thickness * thickness / 4;
  // The prior alone keeps bundles of few points above the floor.
  if (prior < floor * (count + kPriorPoints)) S = floor_eigenvalues(S, floor);
  return {points.front().key, {mean, S, count}};
}

}  // namespace

double least_thickness(const LidarParameters& lidar, const VoxelGrid& grid) {
  return std::max(lidar.range_sigma, 0.02 * grid.edge);
}

const RayBundle* BundleGrid::find(VoxelKey key) const {
  const auto found = std::lower_bound(bundles_.begin(), bundles_.end(), key,
                                      [](const RayBundle& bundle, VoxelKey k) { return bundle.key < k; });
  return found != bundles_.end() && found->key == key ? &*found : nullptr;
}

BundleGrid condense(const Scan& scan, const Pose& T_map_sensor, const VoxelGrid& grid,
                    const LidarParameters& lidar) {
  BundleGrid result;
  result.origin_map = T_map_sensor.translation;
  std::vector<KeyedPoint> points(scan.p_sensor.size());
  for_each_index(points.size(), kGrain, [&](std::size_t i) {
    points[i] = key_of(scan.p_sensor[i], static_cast<std::uint32_t>(i), T_map_sensor, grid, lidar);
  });
  std::array<std::size_t, 4> used{};
  for (const KeyedPoint& point : points) ++used[static_cast<std::size_t>(point.use)];
  result.dropped_near = used[static_cast<std::size_t>(Use::kNear)];
  result.dropped_far = used[static_cast<std::size_t>(Use::kFar)];
  result.dropped_out_of_grid = used[static_cast<std::size_t>(Use::kOutOfGrid)];
  std::erase_if(points, [](const KeyedPoint& point) { return point.use != Use::kTaken; });
  if (points.empty()) return result;

  sort_by_key(points);
  std::vector<std::size_t> begin;  // of each voxel's points
  for (std::size_t i = 0; i < points.size(); ++i) {
    if (i == 0 || points[i].key != points[i - 1].key) begin.push_back(i);
  }
  begin.push_back(points.size());
  const double thickness = least_thickness(lidar, grid);
  result.bundles_.resize(begin.size() - 1);
  for_each_index(result.bundles_.size(), kGrain, [&](std::size_t i) {
    const auto in_voxel = std::span(points).subspan(begin[i], begin[i + 1] - begin[i]);
    result.bundles_[i] = bundle_of(in_voxel, scan, T_map_sensor, grid, thickness);
  });
  return result;
}

}  // namespace evermap
