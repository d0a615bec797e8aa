// SPDX-FileCopyrightText: 2026 the evermap authors
// SPDX-License-Identifier: BSD-3-Clause
#include <algorithm>
#include <array>
#include <bit>
#include <optional>
#include <span>
#include <utility>

#include <evermap/geometry/detail/for_each_index.hpp>
#include <evermap/scan/detail/ray_bundle.hpp>

namespace evermap {
namespace {

constexpr std::size_t kPointsPerTask = 1024;  ///< points or bundles

/// Points of the scan that follow one another in one voxel.
struct Run {
  VoxelKey key;
  std::uint32_t begin, end;  ///< indices in the scan
};

/// What a stretch of the scan's points comes to, besides their places in the map.
struct Stretch {
  std::vector<Run> runs;
  std::size_t dropped_near = 0;
  std::size_t dropped_on_vehicle = 0;
  std::size_t dropped_far = 0;
  std::size_t dropped_out_of_grid = 0;
};

Stretch runs_of(const Scan& scan, std::size_t begin, std::size_t end, const Pose& T_map_sensor,
                const VoxelGrid& grid, const LidarParameters& lidar, std::vector<Eigen::Vector3d>& p_map) {
  Stretch stretch;
  // All keys first: where one run ends and the next begins, nothing foretells, and waiting for it would keep
  // the next points waiting.
  std::array<std::optional<VoxelKey>, kPointsPerTask> keys;
  for (std::size_t i = begin; i < end; ++i) {
    const Eigen::Vector3d& p_sensor = scan.p_sensor[i];
    p_map[i] = T_map_sensor * p_sensor;
    const double range_squared = p_sensor.squaredNorm();
    std::optional<VoxelKey>& key = keys[i - begin];
    if (range_squared < lidar.min_range * lidar.min_range) {
      ++stretch.dropped_near;
    } else if (range_squared > lidar.max_range * lidar.max_range) {
      ++stretch.dropped_far;
    } else if (lidar.vehicle_box.contains(p_sensor)) {
      ++stretch.dropped_on_vehicle;
    } else if (key = grid.key(p_map[i]); !key) {
      ++stretch.dropped_out_of_grid;
    }
  }
  stretch.runs.reserve(end - begin);
  for (auto i = static_cast<std::uint32_t>(begin); i < end; ++i) {
    const std::optional<VoxelKey>& key = keys[i - begin];
    if (!key) continue;
    if (i > begin && keys[i - 1 - begin] == key) {
      ++stretch.runs.back().end;
    } else {
      stretch.runs.push_back({*key, i, i + 1});
    }
  }
  return stretch;
}

/// Sorts by key; runs of one key keep their order. (Radix sort, from the lowest digit up.)
void sort_by_key(std::vector<Run>& runs) {
  constexpr int kBits = 11;
  constexpr std::size_t kBuckets = std::size_t{1} << kBits;
  // A scan spans few blocks. Counted from the lowest one, most of their bits are zero and need no digit.
  VoxelKey corner = runs.front().key;
  for (const Run& run : runs) corner = VoxelKey::lower_corner(corner, run.key);
  const auto offset = [corner](const Run& run) { return run.key.bits() - corner.bits(); };
  std::uint64_t bits = 0;
  for (const Run& run : runs) bits |= offset(run);
  std::vector<Run> sorted(runs.size());
  for (int shift = 0; shift < 64 && bits >> shift != 0; shift += kBits) {
    shift += std::countr_zero(bits >> shift);
    const auto bucket = [&](const Run& run) {
      return static_cast<std::size_t>(offset(run) >> shift) & (kBuckets - 1);
    };
    std::array<std::uint32_t, kBuckets> next{};  // first the sizes of the buckets
    for (const Run& run : runs) ++next[bucket(run)];
    std::uint32_t sum = 0;
    for (std::uint32_t& entry : next) sum += std::exchange(entry, sum);
    for (const Run& run : runs) sorted[next[bucket(run)]++] = run;
    runs.swap(sorted);
  }
}

RayBundle bundle_of(std::span<const Run> runs, std::span<const Eigen::Vector3d> p_map, const VoxelGrid& grid,
                    double thickness) {
  // Moments about the voxel's centre, where coordinates are small and sums lose nothing; in scalars, since
  // the compiler keeps those in registers.
  const Eigen::Vector3d center_map = grid.center(runs.front().key);
  double x = 0, y = 0, z = 0, xx = 0, xy = 0, xz = 0, yy = 0, yz = 0, zz = 0, count = 0;
  for (const Run& run : runs) {
    count += run.end - run.begin;
    for (std::uint32_t i = run.begin; i < run.end; ++i) {
      const Eigen::Vector3d p = p_map[i] - center_map;
      x += p.x(), y += p.y(), z += p.z();
      xx += p.x() * p.x(), xy += p.x() * p.y(), xz += p.x() * p.z();
      yy += p.y() * p.y(), yz += p.y() * p.z(), zz += p.z() * p.z();
    }
  }
  constexpr double kPriorPoints = 2;  // n0: as much trust in the sensor's noise as in two points
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
  return {runs.front().key, {mean, S, count}};
}

}  // namespace

double least_thickness(double range_sigma, const VoxelGrid& grid) {
  return std::max(range_sigma, 0.02 * grid.edge);
}

const RayBundle* BundleGrid::find(VoxelKey key) const {
  if (slots_.empty()) return nullptr;
  const std::uint32_t slot = slots_[slot_of(key.brick())];
  if (slot == 0) return nullptr;
  const BrickOfBundles& brick = bricks_[slot - 1];
  const auto layer = static_cast<std::size_t>(key.voxel_in_brick() >> 6);
  const std::uint64_t bit = std::uint64_t{1} << (key.voxel_in_brick() & 63);
  const std::uint64_t voxels = brick.layers[layer];
  if ((voxels & bit) == 0) return nullptr;
  return &bundles_[brick.first[layer] + static_cast<std::uint32_t>(std::popcount(voxels & (bit - 1)))];
}

std::size_t BundleGrid::slot_of(std::uint64_t brick) const {
  const std::size_t mask = slots_.size() - 1;
  std::size_t slot = hash_bits(brick) & mask;
  while (slots_[slot] != 0 && bricks_[slots_[slot] - 1].brick != brick) slot = (slot + 1) & mask;
  return slot;
}

void BundleGrid::index_bundles() {
  for (std::uint32_t i = 0; i < bundles_.size(); ++i) {
    const VoxelKey key = bundles_[i].key;
    if (bricks_.empty() || bricks_.back().brick != key.brick()) bricks_.push_back({key.brick()});
    BrickOfBundles& brick = bricks_.back();
    const auto layer = static_cast<std::size_t>(key.voxel_in_brick() >> 6);
    if (brick.layers[layer] == 0) brick.first[layer] = i;
    brick.layers[layer] |= std::uint64_t{1} << (key.voxel_in_brick() & 63);
  }
  slots_.resize(std::bit_ceil(2 * bricks_.size() + 1));
  for (std::uint32_t i = 0; i < bricks_.size(); ++i) slots_[slot_of(bricks_[i].brick)] = i + 1;
}

BundleGrid condense(const Scan& scan, const Pose& T_map_sensor, const VoxelGrid& grid,
                    const LidarParameters& lidar, std::size_t max_bundles) {
  BundleGrid result;
  result.origin_map = T_map_sensor.translation;
  result.range_sigma = lidar.range_sigma;
  const std::size_t count = scan.p_sensor.size();
  std::vector<Eigen::Vector3d> p_map(count);
  std::vector<Stretch> stretches(chunks(count, kPointsPerTask));
  for_each_chunk(count, kPointsPerTask, [&](std::size_t chunk, std::size_t begin, std::size_t end) {
    stretches[chunk] = runs_of(scan, begin, end, T_map_sensor, grid, lidar, p_map);
  });
  std::vector<Run> runs;
  runs.reserve(count);
  for (const Stretch& stretch : stretches) {
    result.dropped_near += stretch.dropped_near;
    result.dropped_on_vehicle += stretch.dropped_on_vehicle;
    result.dropped_far += stretch.dropped_far;
    result.dropped_out_of_grid += stretch.dropped_out_of_grid;
    runs.insert(runs.end(), stretch.runs.begin(), stretch.runs.end());
  }
  if (runs.empty()) return result;

  sort_by_key(runs);
  std::vector<std::size_t> begin;  // of each voxel's runs
  for (std::size_t i = 0; i < runs.size(); ++i) {
    if (i == 0 || runs[i].key != runs[i - 1].key) begin.push_back(i);
  }
  begin.push_back(runs.size());
  const double thickness = least_thickness(lidar.range_sigma, grid);
  const std::size_t voxels = begin.size() - 1;
  result.bundles_.resize(std::min(voxels, max_bundles));
  for_each_index(result.bundles_.size(), kPointsPerTask, [&](std::size_t i) {
    const std::size_t voxel = i * voxels / result.bundles_.size();
    const auto in_voxel = std::span(runs).subspan(begin[voxel], begin[voxel + 1] - begin[voxel]);
    result.bundles_[i] = bundle_of(in_voxel, p_map, grid, thickness);
  });
  result.index_bundles();
  return result;
}

}  // namespace evermap
