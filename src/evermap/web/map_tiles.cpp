// SPDX-FileCopyrightText: 2026 the evermap authors
// SPDX-License-Identifier: BSD-3-Clause
#include <algorithm>
#include <cmath>
#include <set>
#include <utility>

#include <Eigen/Eigenvalues>
#include <oneapi/tbb/parallel_for.h>

#include <evermap/map/detail/block_leaves.hpp>
#include <evermap/map/detail/leaf_changes.hpp>
#include <evermap/map/detail/leaf_finder.hpp>
#include <evermap/web/detail/map_tiles.hpp>

namespace evermap {
namespace {

constexpr int kCells = VoxelKey::kBlockEdge;  ///< of a tile, a side
constexpr int kCoarse = 2;                    ///< level of which each block's points are kept

Eigen::Vector3i block_at(std::uint64_t block) {
  return VoxelKey::first_of_block(block).voxel() / VoxelKey::kBlockEdge;
}

/// Keeps one of those in each cell. `cell`: [voxels] its edge.
template <class Drawn>
std::vector<Drawn> thin(const std::vector<Drawn>& all, int cell) {
  std::vector<std::int32_t> chosen(std::size_t{kCells} * kCells * kCells, -1);
  const auto rank = [&](const Drawn& drawn) {
    const Eigen::Array3f in_cell = drawn.position.array() / static_cast<float>(cell);
    const float off_center = (in_cell - in_cell.floor() - 0.5F).matrix().squaredNorm();
    return std::pair(!drawn.is_changed(), off_center);
  };
  for (std::size_t i = 0; i < all.size(); ++i) {
    const auto at = [&](int axis) {
      const float cells = std::floor(all[i].position[axis] / static_cast<float>(cell));
      return static_cast<std::size_t>(std::clamp(cells, 0.0F, kCells - 1.0F));
    };
    std::int32_t& best = chosen[(at(2) * kCells + at(1)) * kCells + at(0)];
    if (best < 0 || rank(all[i]) < rank(all[static_cast<std::size_t>(best)]))
      best = static_cast<std::int32_t>(i);
  }
  std::vector<Drawn> kept;
  kept.reserve(all.size());
  for (const std::int32_t i : chosen) {
    if (i >= 0) kept.push_back(all[static_cast<std::size_t>(i)]);
  }
  return kept;
}

std::size_t leaf_count(const Octree& map, std::uint64_t block_key) {
  std::size_t count = 0;
  if (const Octree::Block* block = map.find_block(block_key))
    block->for_each([&](int, const Brick& brick) { count += brick.size(); });
  return count;
}

}  // namespace

void note_version(const LeafChange& change, bool was_occupied, std::uint16_t version, LeafAges& ages) {
  if (!change.leaf.occupied()) return;
  LeafAge& age = ages[change.key.bits()];
  if (!was_occupied) age.since = version;
  age.seen = version;
}

MapTiles::MapTiles(Octree map, std::optional<Octree> before, LeafAges ages)
    : map_(std::move(map)), before_(std::move(before)), ages_(std::move(ages)) {}

std::vector<TileBlock> MapTiles::blocks() const {
  std::vector<std::uint64_t> keys = map_.block_keys();
  if (before_) {
    const std::vector<std::uint64_t> earlier = before_->block_keys();
    std::vector<std::uint64_t> both;
    both.reserve(keys.size() + earlier.size());
    std::set_union(keys.begin(), keys.end(), earlier.begin(), earlier.end(), std::back_inserter(both));
    keys = std::move(both);
  }
  std::vector<TileBlock> blocks;
  blocks.reserve(keys.size());
  for (const std::uint64_t key : keys) blocks.push_back(describe(key));
  return blocks;
}

TileBlock MapTiles::describe(std::uint64_t block) const {
  const Eigen::Vector3i at = block_at(block);
  const auto revision = revisions_.find(block);
  const std::size_t leaves =
      std::max(leaf_count(map_, block), before_ ? leaf_count(*before_, block) : std::size_t{0});
  return {{at.x(), at.y(), at.z()},
          static_cast<std::uint32_t>(leaves),
          revision == revisions_.end() ? 0 : revision->second};
}

std::vector<MapTiles::DrawnLeaf> MapTiles::leaves_of(std::uint64_t block) const {
  std::vector<DrawnLeaf> leaves;
  const Eigen::Vector3d corner =
      map_.grid().center(VoxelKey::first_of_block(block)) - Eigen::Vector3d::Constant(map_.grid().edge / 2);
  const auto add = [&](const Octree& map, VoxelKey key, const Leaf& leaf, PointChange change) {
    const Eigen::Vector3d p = (map.gaussian(key, leaf).mean - corner) / map.grid().edge;
    leaves.push_back({p.cast<float>(), key, &leaf, change});
  };
  if (!before_) {
    for_each_leaf_of(map_, block, [&](VoxelKey key, const Leaf& leaf) {
      if (leaf.occupied()) add(map_, key, leaf, PointChange::kNone);
    });
    return leaves;
  }
  LeafFinder<const Octree> earlier(*before_);
  for_each_leaf_of(map_, block, [&](VoxelKey key, const Leaf& leaf) {
    if (!leaf.occupied()) return;
    const Leaf* was = earlier.find(key);
    const bool is_same = was != nullptr && was->occupied() && was->mean_in_voxel == leaf.mean_in_voxel;
    const bool is_known = is_same || shows_surface(*before_, key, map_.gaussian(key, leaf).mean);
    add(map_, key, leaf, is_known ? PointChange::kNone : PointChange::kCame);
  });
  LeafFinder<const Octree> now(map_);
  for_each_leaf_of(*before_, block, [&](VoxelKey key, const Leaf& leaf) {
    if (!leaf.occupied()) return;
    const Leaf* is = now.find(key);
    if (is != nullptr && is->occupied()) return;
    if (!shows_surface(map_, key, before_->gaussian(key, leaf).mean))
      add(*before_, key, leaf, PointChange::kWent);
  });
  return leaves;
}

MapTiles::DrawnPoint MapTiles::drawn(const DrawnLeaf& leaf) const {
  Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d> solver;
  solver.computeDirect(leaf.leaf->covariance_matrix());
  const Eigen::Vector3d normal = 127 * solver.eigenvectors().col(0);
  DrawnPoint point{leaf.position, {}};
  for (int axis = 0; axis < 3; ++axis)
    point.point.normal[static_cast<std::size_t>(axis)] = static_cast<std::int8_t>(std::lround(normal[axis]));
  const auto age = ages_.find(leaf.key.bits());
  if (age != ages_.end()) point.point.age = age->second;
  point.point.probability =
      static_cast<std::uint8_t>(std::lround(255 / (1 + std::exp(-leaf.leaf->log_odds))));
  point.point.change = leaf.change;
  return point;
}

std::vector<MapTiles::DrawnPoint> MapTiles::drawn(const std::vector<DrawnLeaf>& leaves) const {
  std::vector<DrawnPoint> points;
  points.reserve(leaves.size());
  for (const DrawnLeaf& leaf : leaves) points.push_back(drawn(leaf));
  return points;
}

std::vector<std::uint64_t> MapTiles::blocks_in(int level, const Eigen::Vector3i& at) const {
  std::set<std::uint64_t> found;
  const auto add_from = [&](const Octree& map) {
    if (level <= kCoarse) {  // few places: each is asked for
      const int edge = 1 << level;
      for (int i = 0; i < edge * edge * edge; ++i) {
        const Eigen::Vector3i block = at * edge + Eigen::Vector3i(i % edge, i / edge % edge, i / edge / edge);
        const Eigen::Vector3i voxel = block * kCells;
        if (!VoxelKey::in_range(voxel)) continue;
        const std::uint64_t key = VoxelKey::from_voxel(voxel).block();
        if (map.find_block(key) != nullptr) found.insert(key);
      }
      return;
    }
    for (const std::uint64_t key : map.block_keys()) {
      const Eigen::Vector3i block = block_at(key);
      if (block.x() >> level == at.x() && block.y() >> level == at.y() && block.z() >> level == at.z())
        found.insert(key);
    }
  };
  add_from(map_);
  if (before_) add_from(*before_);
  return {found.begin(), found.end()};
}

std::vector<TilePoint> MapTiles::tile(int level, const Eigen::Vector3i& at) {
  constexpr int kFarthest = VoxelKey::kMaxXY / kCells;
  if (at.cwiseAbs().maxCoeff() > kFarthest) return {};  // where nothing can be
  const std::vector<std::uint64_t> blocks = blocks_in(level, at);
  const auto offset_of = [&](std::uint64_t block) -> Eigen::Vector3f {
    return ((block_at(block).array() - at.array() * (1 << level)) * kCells).matrix().cast<float>();
  };
  std::vector<DrawnPoint> points;
  if (level < kCoarse) {
    std::vector<DrawnLeaf> leaves;
    for (const std::uint64_t block : blocks) {
      for (DrawnLeaf& leaf : leaves_of(block)) {
        leaf.position += offset_of(block);
        leaves.push_back(leaf);
      }
    }
    if (level > 0) leaves = thin(leaves, 1 << level);
    points = drawn(leaves);
  } else {
    std::vector<std::uint64_t> missing;
    std::copy_if(blocks.begin(), blocks.end(), std::back_inserter(missing),
                 [&](std::uint64_t block) { return !coarse_.contains(block); });
    std::vector<std::vector<DrawnPoint>> made(missing.size());
    oneapi::tbb::parallel_for(std::size_t{0}, missing.size(), [&](std::size_t i) {
      made[i] = drawn(thin(leaves_of(missing[i]), 1 << kCoarse));
    });
    for (std::size_t i = 0; i < missing.size(); ++i) coarse_[missing[i]] = std::move(made[i]);
    for (const std::uint64_t block : blocks) {
      for (DrawnPoint point : coarse_[block]) {
        point.position += offset_of(block);
        points.push_back(point);
      }
    }
    if (level > kCoarse) points = thin(points, 1 << level);
  }
  std::vector<TilePoint> tile;
  tile.reserve(points.size());
  const float step = 65536.0F / static_cast<float>(kCells << level);
  for (DrawnPoint& point : points) {
    for (int axis = 0; axis < 3; ++axis) {
      point.point.position[static_cast<std::size_t>(axis)] =
          static_cast<std::uint16_t>(std::clamp(point.position[axis] * step, 0.0F, 65535.0F));
    }
    tile.push_back(point.point);
  }
  return tile;
}

std::vector<TileBlock> MapTiles::show(Octree map, std::uint16_t since) {
  const auto least_move = static_cast<float>(map.grid().edge / 8);
  std::set<std::uint64_t> changed;
  for (const LeafChange& change : changes_between(map_, map)) {
    const Leaf* was = map_.find(change.key);
    const bool was_drawn = was != nullptr && was->occupied();
    const bool is_drawn = change.leaf.occupied();
    if (was_drawn != is_drawn ||
        (is_drawn && (was->mean_in_voxel - change.leaf.mean_in_voxel).norm() > least_move))
      changed.insert(change.key.block());
    note_version(change, was_drawn, since, ages_);
  }
  map_ = std::move(map);
  ++revision_;
  std::vector<TileBlock> blocks;
  blocks.reserve(changed.size());
  for (const std::uint64_t block : changed) {
    revisions_[block] = revision_;
    coarse_.erase(block);
    blocks.push_back(describe(block));
  }
  return blocks;
}

}  // namespace evermap
