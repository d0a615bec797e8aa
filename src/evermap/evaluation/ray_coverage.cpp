// SPDX-FileCopyrightText: 2026 the evermap authors
// SPDX-License-Identifier: BSD-3-Clause
#include <algorithm>
#include <array>
#include <limits>
#include <unordered_map>

#include <evermap/evaluation/ray_coverage.hpp>

namespace evermap {
namespace {

/// Counters of the 512 voxels of whole bricks: a walk looks up a brick every few steps instead of every
/// voxel.
using BrickCounts = std::array<std::uint8_t, 512>;
using Counts = std::unordered_map<std::uint64_t, BrickCounts>;

std::uint64_t brick_of(VoxelKey key) { return key.bits() >> 9; }

Counts empty_counts(const Points& points, const VoxelGrid& grid) {
  Counts counts;
  for (const Eigen::Vector3d& p : points) {
    if (const auto key = grid.key(p)) counts.try_emplace(brick_of(*key), BrickCounts{});
  }
  return counts;
}

/// Walks the voxels along a ray (Amanatides and Woo, 1987), in units of voxels. Crossing times are computed
/// from the voxel's integer faces each step instead of summed up, so that rounding does not grow with length.
class VoxelWalk {
 public:
  VoxelWalk(const Eigen::Vector3d& origin, const Eigen::Vector3d& direction)
      : origin_(origin), direction_(direction), voxel_(origin.array().floor().cast<int>()) {
    for (int axis = 0; axis < 3; ++axis) update_face_time(axis);
  }

  const Eigen::Vector3i& voxel() const { return voxel_; }
  double exit_time() const { return face_time_.minCoeff(); }
  void step() {
    int axis = 0;
    face_time_.minCoeff(&axis);
    voxel_[axis] += direction_[axis] > 0 ? 1 : -1;
    update_face_time(axis);
  }

 private:
  void update_face_time(int axis) {
    const double face = direction_[axis] > 0 ? voxel_[axis] + 1 : voxel_[axis];
    face_time_[axis] = direction_[axis] == 0 ? std::numeric_limits<double>::infinity()
                                             : (face - origin_[axis]) / direction_[axis];
  }

  Eigen::Vector3d origin_;
  Eigen::Vector3d direction_;
  Eigen::Vector3i voxel_;
  Eigen::Vector3d face_time_;
};

/// REQUIRES: both ends have keys in the grid.
void count_ray(const Eigen::Vector3d& origin, const Eigen::Vector3d& end, const VoxelGrid& grid,
               double margin, Counts& counts) {
  const double length = (end - origin).norm();
  const double last_exit = (length - margin) / grid.edge;
  if (!(last_exit > 0)) return;
  VoxelWalk walk((origin - grid.origin) / grid.edge, (end - origin) / length);
  std::uint64_t brick = std::numeric_limits<std::uint64_t>::max();
  BrickCounts* brick_counts = nullptr;
  double entry = 0;
  while (walk.exit_time() < last_exit) {
    const double exit = walk.exit_time();
    const VoxelKey key = VoxelKey::from_voxel(walk.voxel());
    if (brick_of(key) != brick) {
      brick = brick_of(key);
      const auto found = counts.find(brick);
      brick_counts = found == counts.end() ? nullptr : &found->second;
    }
    if (brick_counts != nullptr && exit > entry) {
      std::uint8_t& count = (*brick_counts)[static_cast<std::size_t>(key.voxel_in_brick())];
      if (count < std::numeric_limits<std::uint8_t>::max()) ++count;
    }
    entry = exit;
    walk.step();
  }
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
  Counts counts = empty_counts(points, grid);
  for (const ScanRays& scan : scans) {
    if (!grid.key(scan.origin)) continue;
    for (const Eigen::Vector3d& end : scan.ends) {
      if (grid.key(end)) count_ray(scan.origin, end, grid, margin, counts);
    }
  }
  std::vector<std::uint8_t> rays(points.size(), 0);
  for (std::size_t i = 0; i < points.size(); ++i) {
    if (const auto key = grid.key(points[i])) {
      rays[i] = counts.at(brick_of(*key))[static_cast<std::size_t>(key->voxel_in_brick())];
    }
  }
  return rays;
}

Points contradictable(const Points& points, const VoxelGrid& grid, const std::vector<ScanRays>& scans) {
  constexpr int kRays = 4;
  constexpr double kMargin = 1.5;  ///< [voxels]
  const std::vector<std::uint8_t> rays = rays_beyond(points, grid, scans, kMargin * grid.edge);
  return select(points, [&](std::size_t i) { return rays[i] >= kRays; });
}

Points observed(const Points& points, const std::vector<ScanRays>& scans, double reach) {
  Points ends;
  for (const ScanRays& scan : scans) ends.insert(ends.end(), scan.ends.begin(), scan.ends.end());
  const std::vector<double> distance = nearest_distances(points, ends);
  return select(points, [&](std::size_t i) { return distance[i] <= reach; });
}

}  // namespace evermap
