// SPDX-FileCopyrightText: 2026 the evermap authors
// SPDX-License-Identifier: BSD-3-Clause
#include <algorithm>
#include <array>
#include <atomic>
#include <limits>
#include <unordered_map>

#include <evermap/evaluation/ray_coverage.hpp>
#include <evermap/geometry/detail/for_each_index.hpp>
#include <evermap/map/detail/voxel_walk.hpp>

namespace evermap {
namespace {

/// Counts for the voxels that hold points, by bricks of 8 x 8 x 8, so that a walk leaps over empty space.
class VoxelCounts {
 public:
  VoxelCounts(const Points& points, const VoxelGrid& grid) {
    for (const Eigen::Vector3d& p : points) {
      if (const auto key = grid.key(p)) bricks_.try_emplace(key->brick());
    }
  }

  bool has_brick(VoxelKey key) const { return bricks_.contains(key.brick()); }
  /// Thread safe. REQUIRES: has_brick(key).
  void add(VoxelKey key) { at(key).fetch_add(1, std::memory_order_relaxed); }
  std::uint8_t count(VoxelKey key) {
    constexpr std::uint32_t kMost = std::numeric_limits<std::uint8_t>::max();
    return static_cast<std::uint8_t>(std::min(kMost, at(key).load()));
  }

 private:
  using Brick = std::array<std::atomic<std::uint32_t>, 512>;

  std::atomic<std::uint32_t>& at(VoxelKey key) {
    return bricks_.find(key.brick())->second[static_cast<std::size_t>(key.voxel_in_brick())];
  }

  std::unordered_map<std::uint64_t, Brick> bricks_;
};

/// The voxels, in bricks with points, that a ray crosses and leaves more than `margin` [m] behind.
/// REQUIRES: both ends have keys in the grid.
void add_crossed(const Ray& ray, const VoxelGrid& grid, double margin, const VoxelCounts& counts,
                 std::vector<VoxelKey>& crossed) {
  constexpr int kBrickLevel = 3;
  const double until = (ray.length() - margin) / ray.length();
  if (!(until > 0)) return;
  VoxelWalk walk(VoxelRay::of(grid, ray), *grid.voxel(ray.origin));
  while (walk.entry() < until && VoxelKey::in_range(walk.voxel())) {
    const VoxelKey key = VoxelKey::from_voxel(walk.voxel());
    if (!counts.has_brick(key)) {
      walk.leap(walk.exit(kBrickLevel));
      continue;
    }
    if (walk.entry() < walk.exit() && walk.exit() < until) crossed.push_back(key);
    walk.step();
  }
}

/// Counts the crossings by rays of each point's voxel, or those by scans, of which one ray is enough.
std::vector<std::uint8_t> crossings(const Points& points, const VoxelGrid& grid,
                                    const std::vector<ScanRays>& scans, double margin, bool once_a_scan) {
  VoxelCounts counts(points, grid);
  for_each_index(scans.size(), 1, [&](std::size_t i) {
    const ScanRays& scan = scans[i];
    if (!grid.key(scan.origin)) return;
    std::vector<VoxelKey> crossed;
    for (const Eigen::Vector3d& end : scan.ends) {
      if (grid.key(end)) add_crossed({scan.origin, end}, grid, margin, counts, crossed);
    }
    if (once_a_scan) {
      std::sort(crossed.begin(), crossed.end());
      crossed.erase(std::unique(crossed.begin(), crossed.end()), crossed.end());
    }
    for (const VoxelKey key : crossed) counts.add(key);
  });
  std::vector<std::uint8_t> of_points(points.size(), 0);
  for (std::size_t i = 0; i < points.size(); ++i) {
    if (const auto key = grid.key(points[i])) of_points[i] = counts.count(*key);
  }
  return of_points;
}

template <class Predicate>
Points select(const Points& points, const Predicate& wanted) {
  Points selected;
  for (std::size_t i = 0; i < points.size(); ++i) {
    if (wanted(i)) selected.push_back(points[i]);
  }
  return selected;
}

}  // namespace

std::vector<std::uint8_t> rays_beyond(const Points& points, const VoxelGrid& grid,
                                      const std::vector<ScanRays>& scans, double margin) {
  return crossings(points, grid, scans, margin, false);
}

std::vector<std::uint8_t> scans_beyond(const Points& points, const VoxelGrid& grid,
                                       const std::vector<ScanRays>& scans, double margin) {
  return crossings(points, grid, scans, margin, true);
}

Points contradictable(const Points& points, const VoxelGrid& grid, const std::vector<ScanRays>& scans) {
  constexpr int kRays = 4;
  constexpr double kMargin = 1.5;  ///< [voxels]
  const std::vector<std::uint8_t> rays = rays_beyond(points, grid, scans, kMargin * grid.edge);
  return select(points, [&](std::size_t i) { return rays[i] >= kRays; });
}

}  // namespace evermap
