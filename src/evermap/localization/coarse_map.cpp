// SPDX-FileCopyrightText: 2026 the evermap authors
// SPDX-License-Identifier: BSD-3-Clause
#include <cmath>

#include <evermap/localization/detail/coarse_map.hpp>

namespace evermap {
namespace {

constexpr double kRadius = 50;      ///< [m] around the place: what is farther turns too fast to help
constexpr double kCoarsest = 2.5;   ///< [m] edge at least, so that a metre stays within reach
constexpr double kSureLogOdds = 3;  ///< of coarse leaves: surface is there

void add(Octree& view, const Gaussian& surface) {
  const auto key = view.grid().key(surface.mean);
  if (!key) return;
  Leaf& leaf = view.find_or_insert(*key);
  const Eigen::Vector3d center_map = view.grid().center(*key);
  leaf.set_gaussian(leaf.count > 0 ? merge(leaf.gaussian(center_map), surface) : surface, center_map);
  leaf.log_odds = kSureLogOdds;
}

}  // namespace

std::vector<Octree> coarse_views(const Octree& map, const Eigen::Vector3d& center_map) {
  std::vector<Octree> views;
  const auto voxel = map.grid().voxel(center_map);
  if (!voxel || map.grid().edge >= kCoarsest) return views;
  const auto reach = Eigen::Vector3i::Constant(static_cast<int>(std::ceil(kRadius / map.grid().edge)));
  Octree first(VoxelGrid{2 * map.grid().edge, map.grid().origin});
  for (const PlacedBrick& placed : map.bricks_in({*voxel - reach, *voxel + reach})) {
    placed.brick->for_each([&](int index, const Leaf& leaf) {
      const VoxelKey key = placed.key(index);
      if (leaf.occupied()) add(first, map.gaussian(key, leaf));
    });
  }
  views.push_back(std::move(first));
  while (views.back().grid().edge < kCoarsest) {
    const Octree& finer = views.back();
    Octree view(VoxelGrid{2 * finer.grid().edge, finer.grid().origin});
    finer.for_each_leaf([&](VoxelKey key, const Leaf& leaf) { add(view, finer.gaussian(key, leaf)); });
    views.push_back(std::move(view));
  }
  return views;
}

}  // namespace evermap
