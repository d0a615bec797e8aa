// SPDX-FileCopyrightText: 2026 the evermap authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <optional>
#include <unordered_map>
#include <vector>

#include <Eigen/Core>

#include <evermap/map/detail/leaf_changes.hpp>
#include <evermap/map/detail/surface_changes.hpp>
#include <evermap/map/octree.hpp>

namespace evermap {

/// Since when a leaf is there, and when it was last written, as numbers of versions.
struct LeafAge {
  std::uint16_t since = 0;
  std::uint16_t seen = 0;
};
/// By the bits of a leaf's key. What is not listed is as old as the history.
using LeafAges = std::unordered_map<std::uint64_t, LeafAge>;

/// A version wrote this leaf. One that went keeps its age.
void note_version(const LeafChange& change, bool was_occupied, std::uint16_t version, LeafAges& ages);

/// What became of a surface since an earlier map.
enum class PointChange : std::uint8_t { kNone = 0, kCame = 1, kWent = 2 };

/// A leaf as a page draws it, or the leaf that stands for a cell of several. Sent as it lies in memory,
/// little endian.
struct TilePoint {
  std::array<std::uint16_t, 3> position{};  ///< in the tile [its edge / 65536]
  LeafAge age;
  std::array<std::int8_t, 3> normal{};  ///< [1 / 127] of either sign
  std::uint8_t probability = 0;         ///< [1 / 255] of occupancy
  PointChange change = PointChange::kNone;
  std::uint8_t spare = 0;
};
static_assert(sizeof(TilePoint) == 16);

/// A block of 64 x 64 x 64 voxels that holds leaves. Sent as it lies in memory, little endian.
struct TileBlock {
  std::array<std::int32_t, 3> at{};  ///< [blocks] from the grid's origin
  std::uint32_t leaves = 0;
  std::uint32_t revision = 0;  ///< grows whenever what is drawn of the block changes
};
static_assert(sizeof(TileBlock) == 20);

/// A map in levels of detail, for drawing. A tile of level k is a cube of 64 cells a side, each of 2^k
/// voxels, of which one leaf is drawn: what changed before what did not, then the nearest to the cell's
/// centre. Level 0 has all leaves, its tiles are the octree's blocks.
///
/// With an earlier map, its surface that went is drawn, too. Not thread safe.
class MapTiles {
 public:
  static constexpr int kTopLevel = 15;  ///< one tile of it is larger than any map

  explicit MapTiles(Octree map, std::optional<Octree> before = std::nullopt, LeafAges ages = {});

  const Octree& map() const { return map_; }
  const std::optional<Octree>& before() const { return before_; }

  std::vector<TileBlock> blocks() const;
  /// REQUIRES: 0 <= level <= kTopLevel.
  std::vector<TilePoint> tile(int level, const Eigen::Vector3i& at);

  /// Draws this map from now on, whose new leaves are of version `since`. Returns the blocks that are drawn
  /// differently: where a leaf came or went, or moved by an eighth of its edge. REQUIRES: the same grid.
  std::vector<TileBlock> show(Octree map, std::uint16_t since);

 private:
  /// A leaf that is to be drawn.
  struct DrawnLeaf {
    Eigen::Vector3f position;  ///< [voxels] from the corner of its block, later of the tile
    VoxelKey key;
    const Leaf* leaf;
    PointChange change;
    bool is_changed() const { return change != PointChange::kNone; }
  };
  struct DrawnPoint {
    Eigen::Vector3f position;  ///< likewise
    TilePoint point;           ///< but for its position
    bool is_changed() const { return point.change != PointChange::kNone; }
  };

  std::vector<DrawnLeaf> leaves_of(std::uint64_t block) const;
  DrawnPoint drawn(const DrawnLeaf& leaf) const;
  std::vector<DrawnPoint> drawn(const std::vector<DrawnLeaf>& leaves) const;
  TileBlock describe(std::uint64_t block) const;
  /// The blocks of a tile that hold something.
  std::vector<std::uint64_t> blocks_in(int level, const Eigen::Vector3i& at) const;

  Octree map_;
  std::optional<Octree> before_;
  LeafAges ages_;
  /// Of blocks that were asked for in a coarse tile: a sixteenth of the leaves.
  std::unordered_map<std::uint64_t, std::vector<DrawnPoint>> coarse_;
  std::unordered_map<std::uint64_t, std::uint32_t> revisions_;  ///< of blocks that changed
  std::uint32_t revision_ = 0;
};

}  // namespace evermap
