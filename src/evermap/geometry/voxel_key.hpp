// SPDX-FileCopyrightText: 2026 the evermap authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <array>
#include <cmath>
#include <cstdint>
#include <optional>

#include <Eigen/Core>

namespace evermap {

/// Names one voxel of a grid by a 64-bit integer, ordered brick by brick.
///
///   bit 63       41        19       9 8  6 5  3 2  0
///       | brick x | brick y | brick z | z | y | x |       brick = 8 x 8 x 8 voxels
///          19 bits   19 bits   17 bits   3   3   3
///
/// The upper 55 bits name the brick, the lower 9 the voxel in it, so that sorting keys sorts by brick and a
/// brick's occupancy is a mask of 512 bits indexed by `in_brick()`. Coordinates reach +-2^21 voxels in x and
/// y and +-2^19 in z from the grid's origin (at 0.1 m: 209 km and 52 km).
class VoxelKey {
 public:
  static constexpr int kBrickBits = 3;  ///< log2 of the voxels along a brick's edge
  static constexpr int kBrickEdge = 1 << kBrickBits;
  static constexpr int kBrickVoxels = kBrickEdge * kBrickEdge * kBrickEdge;
  static constexpr int kMaxXY = 1 << 21;
  static constexpr int kMaxZ = 1 << 19;

  VoxelKey() = default;
  explicit VoxelKey(std::uint64_t bits) : bits_(bits) {}

  static bool in_range(const Eigen::Vector3i& v) {
    return v.x() >= -kMaxXY && v.x() < kMaxXY && v.y() >= -kMaxXY && v.y() < kMaxXY && v.z() >= -kMaxZ &&
           v.z() < kMaxZ;
  }

  /// REQUIRES: in_range(voxel).
  static VoxelKey from_voxel(const Eigen::Vector3i& voxel) {
    const auto x = static_cast<std::uint64_t>(voxel.x() + kMaxXY);
    const auto y = static_cast<std::uint64_t>(voxel.y() + kMaxXY);
    const auto z = static_cast<std::uint64_t>(voxel.z() + kMaxZ);
    return VoxelKey((x >> 3) << 45 | (y >> 3) << 26 | (z >> 3) << 9 | (z & 7) << 6 | (y & 7) << 3 | (x & 7));
  }

  Eigen::Vector3i voxel() const {
    const auto brick_x = static_cast<int>(bits_ >> 45);
    const auto brick_y = static_cast<int>(bits_ >> 26 & 0x7FFFF);
    const auto brick_z = static_cast<int>(bits_ >> 9 & 0x1FFFF);
    return {(brick_x << 3 | static_cast<int>(bits_ & 7)) - kMaxXY,
            (brick_y << 3 | static_cast<int>(bits_ >> 3 & 7)) - kMaxXY,
            (brick_z << 3 | static_cast<int>(bits_ >> 6 & 7)) - kMaxZ};
  }

  std::uint64_t bits() const { return bits_; }
  std::uint64_t brick() const { return bits_ >> 9; }
  int in_brick() const { return static_cast<int>(bits_ & 511); }

  friend auto operator<=>(VoxelKey, VoxelKey) = default;

 private:
  std::uint64_t bits_ = 0;
};

/// Finalizer of SplitMix64 (Steele et al., 2014): spreads a key over all 64 bits, for open addressing.
inline std::uint64_t hash_bits(std::uint64_t x) {
  x = (x ^ (x >> 30)) * 0xbf58476d1ce4e5b9U;
  x = (x ^ (x >> 27)) * 0x94d049bb133111ebU;
  return x ^ (x >> 31);
}

/// The division of the map frame into cubes. The scan filter and the map share one grid.
///
/// `origin` keeps keys small for maps far from the map frame's origin (UTM coordinates, say): voxel (0,0,0)
/// has its lower corner there. It is a whole multiple of kOriginStep voxels, so that maps of one place agree
/// on it.
struct VoxelGrid {
  static constexpr double kOriginStep = 65536;  ///< [voxels]

  double edge = 0.2;                                 ///< [m] voxel edge length l
  Eigen::Vector3d origin = Eigen::Vector3d::Zero();  ///< [m] map frame

  /// The grid of edge length `edge` whose origin suits data around `p_map`.
  static VoxelGrid around(const Eigen::Vector3d& p_map, double edge) {
    const double step = kOriginStep * edge;
    return {edge, (p_map / step).array().round().matrix() * step};
  }

  /// The voxel that contains `p_map`, without regard to the range of keys. REQUIRES: the coordinates fit an
  /// int.
  Eigen::Vector3i voxel(const Eigen::Vector3d& p_map) const {
    return ((p_map - origin) / edge).array().floor().cast<int>();
  }
  /// The key of the voxel that contains `p_map`; none when it is not finite or beyond the range of keys.
  std::optional<VoxelKey> key(const Eigen::Vector3d& p_map) const {
    const Eigen::Vector3d scaled = ((p_map - origin) / edge).array().floor();
    if (!(scaled.cwiseAbs().maxCoeff() < VoxelKey::kMaxXY)) return std::nullopt;  // NaN compares false
    const Eigen::Vector3i v = scaled.cast<int>();
    if (!VoxelKey::in_range(v)) return std::nullopt;
    return VoxelKey::from_voxel(v);
  }
  Eigen::Vector3d center(const Eigen::Vector3i& v) const {
    return origin + edge * (v.cast<double>().array() + 0.5).matrix();
  }
  Eigen::Vector3d center(VoxelKey key) const { return center(key.voxel()); }

  friend bool operator==(const VoxelGrid&, const VoxelGrid&) = default;
};

}  // namespace evermap
