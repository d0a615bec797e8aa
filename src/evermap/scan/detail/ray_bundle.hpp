// SPDX-FileCopyrightText: 2026 the evermap authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <vector>

#include <evermap/geometry/gaussian.hpp>
#include <evermap/geometry/pose.hpp>
#include <evermap/geometry/voxel_key.hpp>
#include <evermap/scan/lidar_parameters.hpp>
#include <evermap/scan/scan.hpp>

namespace evermap {

/// The points of one scan that fell into one voxel, as one Gaussian in the map frame.
struct RayBundle {
  VoxelKey key;     ///< the voxel; its grid is the map's
  Gaussian points;  ///< N_R(mu_R, S_R), n_R; S_R is positive definite
};

/// A scan condensed into ray bundles, findable by voxel. Const members are thread safe.
class BundleGrid {
 public:
  /// Class invariant: at most one bundle per voxel, in ascending order of keys: neighbours in the map are
  /// neighbours in memory.
  const std::vector<RayBundle>& bundles() const { return bundles_; }
  /// The bundle of this voxel, if any.
  const RayBundle* find(VoxelKey key) const;

  Eigen::Vector3d origin_map = Eigen::Vector3d::Zero();  ///< [m] o, the sensor's position
  double range_sigma = 0;                                ///< [m] of the returns' distances
  std::size_t dropped_near = 0;                          ///< points below min_range
  std::size_t dropped_on_vehicle = 0;                    ///< points in vehicle_box
  std::size_t dropped_far = 0;                           ///< points above max_range
  std::size_t dropped_out_of_grid = 0;                   ///< points beyond the range of keys

 private:
  friend BundleGrid condense(const Scan&, const Pose&, const VoxelGrid&, const LidarParameters&, std::size_t);

  /// The bundles of one brick of voxels: which there are, and where.
  struct BrickOfBundles {
    std::uint64_t brick;
    std::array<std::uint64_t, 8> layers{};  ///< bits of the voxels that have one, layer by layer
    std::array<std::uint32_t, 8> first{};   ///< index of each layer's first bundle
  };

  void index_bundles();
  /// Where a brick is in the hash table, or would be.
  std::size_t slot_of(std::uint64_t brick) const;

  std::vector<RayBundle> bundles_;
  std::vector<BrickOfBundles> bricks_;
  std::vector<std::uint32_t> slots_;  ///< hash table of indices into bricks_, plus 1; 0 is empty
};

/// The restricted voxel grid: all points of the scan in one voxel become one bundle.
///
/// The covariance is shrunk towards the sensor's noise, S = (scatter + n0 s0^2 I) / (n + n0) with n0 = 2 and
/// s0 = max(range_sigma, 0.02 l), and its eigenvalues are floored at (s0 / 2)^2, so that bundles of one or
/// two points and exact planes stay invertible. Of more than `max_bundles`, as many are made, evenly spread
/// over the keys. Runs in parallel in the caller's TBB arena, with the same result for any number of
/// threads.
BundleGrid condense(const Scan& scan, const Pose& T_map_sensor, const VoxelGrid& grid,
                    const LidarParameters& lidar,
                    std::size_t max_bundles = std::numeric_limits<std::size_t>::max());

/// The thickness s0 [m] that a surface has at least, for this sensor and voxel size.
double least_thickness(double range_sigma, const VoxelGrid& grid);

}  // namespace evermap
