// SPDX-FileCopyrightText: 2026 the evermap authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <algorithm>
#include <cstdint>
#include <optional>

#include <Eigen/Core>

namespace evermap {

/// Names one voxel of a grid by a 64-bit integer: the path from the root of the octree to the leaf, three
/// levels of halving folded into each step of 9 bits.
///
///   bit 63                      18            9               0
///       | block x 16, y 16, z 14 | brick z y x | voxel z y x |
///        64 x 64 x 64 voxels      in the block   in the brick
///
/// Sorting keys therefore sorts by block, then brick. Coordinates reach +-2^21 voxels in x and y and +-2^19
/// in z from the grid's origin (at 0.1 m: 209 km and 52 km).
class VoxelKey {
 public:
  static constexpr int kMaxXY = 1 << 21;
  static constexpr int kMaxZ = 1 << 19;
  static constexpr int kBrickEdge = 8;   ///< [voxels]
  static constexpr int kBlockEdge = 64;  ///< [voxels]
  static constexpr std::uint32_t kVoxelsPerBlock = 1U << 18;

  VoxelKey() = default;
  explicit VoxelKey(std::uint64_t bits) : bits_(bits) {}

  static bool in_range(const Eigen::Vector3i& v) {
    return v.x() >= -kMaxXY && v.x() < kMaxXY && v.y() >= -kMaxXY && v.y() < kMaxXY && v.z() >= -kMaxZ &&
           v.z() < kMaxZ;
  }

  /// REQUIRES: in_range(voxel).
  static VoxelKey from_voxel(const Eigen::Vector3i& voxel) {
    const auto x = static_cast<std::uint64_t>(std::int64_t{voxel.x()} + kMaxXY);
    const auto y = static_cast<std::uint64_t>(std::int64_t{voxel.y()} + kMaxXY);
    const auto z = static_cast<std::uint64_t>(std::int64_t{voxel.z()} + kMaxZ);
    const auto child = [&](int level) {  // position among the 512 children of one wide node
      return (z >> level & 7) << 6 | (y >> level & 7) << 3 | (x >> level & 7);
    };
    return VoxelKey((x >> 6) << 48 | (y >> 6) << 32 | (z >> 6) << 18 | child(3) << 9 | child(0));
  }

  Eigen::Vector3i voxel() const {
    const auto axis = [&](std::uint64_t block, int shift) {
      return static_cast<int>(block << 6 | (bits_ >> (9 + shift) & 7) << 3 | (bits_ >> shift & 7));
    };
    return {axis(bits_ >> 48, 0) - kMaxXY, axis(bits_ >> 32 & 0xFFFF, 3) - kMaxXY,
            axis(bits_ >> 18 & 0x3FFF, 6) - kMaxZ};
  }

  /// The first voxel of the block that is, axis by axis, at the lesser place of both keys' blocks. No axis of
  /// a key minus such a corner borrows from another.
  static VoxelKey lower_corner(VoxelKey a, VoxelKey b) {
    constexpr std::uint64_t kX = 0xFFFF000000000000U;
    constexpr std::uint64_t kY = 0x0000FFFF00000000U;
    constexpr std::uint64_t kZ = 0x00000000FFFC0000U;
    return VoxelKey(std::min(a.bits_ & kX, b.bits_ & kX) | std::min(a.bits_ & kY, b.bits_ & kY) |
                    std::min(a.bits_ & kZ, b.bits_ & kZ));
  }

  std::uint64_t bits() const { return bits_; }
  std::uint64_t block() const { return bits_ >> 18; }  ///< the same for all voxels of one block
  std::uint64_t brick() const { return bits_ >> 9; }   ///< the same for all voxels of one brick
  int brick_in_block() const { return static_cast<int>(bits_ >> 9 & 511); }
  int voxel_in_brick() const { return static_cast<int>(bits_ & 511); }
  std::uint32_t voxel_in_block() const { return static_cast<std::uint32_t>(bits_ & (kVoxelsPerBlock - 1)); }

  /// Whether a number can be a block().
  static bool is_block(std::uint64_t block) { return block >> 46 == 0; }
  /// The first voxel of a block. REQUIRES: is_block(block).
  static VoxelKey first_of_block(std::uint64_t block) { return VoxelKey(block << 18); }
  /// The first voxel of a brick of this key's block. REQUIRES: 0 <= brick_in_block < 512.
  VoxelKey first_of_brick(int brick_in_block) const {
    return VoxelKey(block() << 18 | static_cast<std::uint64_t>(brick_in_block) << 9);
  }
  /// A voxel of this key's brick. REQUIRES: 0 <= voxel_in_brick < 512.
  VoxelKey with_voxel(int voxel_in_brick) const {
    return VoxelKey(brick() << 9 | static_cast<std::uint64_t>(voxel_in_brick));
  }
  /// A voxel of this key's block. REQUIRES: voxel_in_block < kVoxelsPerBlock.
  VoxelKey with_voxel_in_block(std::uint32_t voxel_in_block) const {
    return VoxelKey(block() << 18 | voxel_in_block);
  }

  friend auto operator<=>(VoxelKey, VoxelKey) = default;  // NOLINT(modernize-use-nullptr): its literal zero

 private:
  std::uint64_t bits_ = 0;
};

/// Finalizer of SplitMix64 (Steele et al., 2014): spreads a key over all 64 bits, for hash tables.
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
    const Eigen::Vector3d origin = (p_map / step).array().round().matrix() * step;
    return {edge, origin + Eigen::Vector3d::Zero()};  // without a zero's sign: equal grids are the same bits
  }

  /// The voxel that contains `p_map`; none when it is not finite or beyond the range of keys.
  std::optional<Eigen::Vector3i> voxel(const Eigen::Vector3d& p_map) const {
    const Eigen::Vector3d scaled = ((p_map - origin) / edge).array().floor();
    const auto reaches = [](double x, int limit) { return x >= -limit && x < limit; };  // no NaN does
    if (!reaches(scaled.x(), VoxelKey::kMaxXY) || !reaches(scaled.y(), VoxelKey::kMaxXY) ||
        !reaches(scaled.z(), VoxelKey::kMaxZ)) {
      return std::nullopt;
    }
    return scaled.cast<int>();
  }
  std::optional<VoxelKey> key(const Eigen::Vector3d& p_map) const {
    const auto v = voxel(p_map);
    if (!v) return std::nullopt;
    return VoxelKey::from_voxel(*v);
  }
  Eigen::Vector3d center(const Eigen::Vector3i& v) const {
    return origin + edge * (v.cast<double>().array() + 0.5).matrix();
  }
  Eigen::Vector3d center(VoxelKey key) const { return center(key.voxel()); }

  friend bool operator==(const VoxelGrid& a, const VoxelGrid& b) {
    return a.edge == b.edge && a.origin == b.origin;
  }
};

}  // namespace evermap
