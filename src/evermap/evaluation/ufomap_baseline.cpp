// SPDX-FileCopyrightText: 2026 the evermap authors
// SPDX-License-Identifier: BSD-3-Clause
#include <ufo/map/occupancy_map.h>

#include <evermap/evaluation/leaf_cube.hpp>
#include <evermap/evaluation/ufomap_baseline.hpp>

namespace evermap {
namespace {

ufo::map::Point3 to_ufomap(const Eigen::Vector3d& p) { return {p.x(), p.y(), p.z()}; }

}  // namespace

struct UfoMapBaseline::Tree : ufo::map::OccupancyMap {
  using ufo::map::OccupancyMap::OccupancyMap;
};

UfoMapBaseline::UfoMapBaseline(double edge) : tree_(std::make_unique<Tree>(edge)) {}
UfoMapBaseline::~UfoMapBaseline() = default;
UfoMapBaseline::UfoMapBaseline(UfoMapBaseline&&) noexcept = default;
UfoMapBaseline& UfoMapBaseline::operator=(UfoMapBaseline&&) noexcept = default;

void UfoMapBaseline::insert_surface(const Points& points_map) {
  // An update by the maximum lifts any leaf to it; setOccupancy of UFOMap 1.0 does not compile.
  for (const Eigen::Vector3d& p_map : points_map) {
    tree_->updateOccupancy(to_ufomap(p_map), tree_->getClampingThresMax());
  }
}

std::function<void()> UfoMapBaseline::prepare_scan(const Eigen::Vector3d& origin_map,
                                                   const Points& points_map) {
  const auto cloud = std::make_shared<ufo::map::PointCloud>();
  cloud->reserve(points_map.size());
  for (const Eigen::Vector3d& p_map : points_map) cloud->push_back(to_ufomap(p_map));
  return [&tree = *tree_, origin = to_ufomap(origin_map), cloud] {
    tree.insertPointCloudDiscrete(origin, *cloud);
  };
}

bool UfoMapBaseline::occupied(const Eigen::Vector3d& p_map) const {
  return tree_->isOccupied(to_ufomap(p_map));
}

Points UfoMapBaseline::occupied_centers() const {
  Points centers;
  for (auto leaf = tree_->beginLeaves(true, false, false); leaf != tree_->endLeaves(); ++leaf) {
    const auto center = leaf.getCenter();
    add_leaf_centers({center.x(), center.y(), center.z()}, tree_->getResolution(), 1 << leaf.getDepth(),
                     centers);
  }
  return centers;
}

std::size_t UfoMapBaseline::memory_bytes() const { return tree_->memoryUsage(); }

std::string UfoMapBaseline::version() { return EVERMAP_UFOMAP_VERSION; }

}  // namespace evermap
