// SPDX-FileCopyrightText: 2026 the evermap authors
// SPDX-License-Identifier: BSD-3-Clause
#include <octomap/octomap.h>

#include <evermap/evaluation/leaf_cube.hpp>
#include <evermap/evaluation/octomap_baseline.hpp>

namespace evermap {
namespace {

octomap::point3d to_octomap(const Eigen::Vector3d& p) {
  const Eigen::Vector3f single = p.cast<float>();
  return {single.x(), single.y(), single.z()};
}

}  // namespace

struct OctoMapBaseline::Tree : octomap::OcTree {
  using octomap::OcTree::OcTree;
};

OctoMapBaseline::OctoMapBaseline(double edge) : tree_(std::make_unique<Tree>(edge)) {}
OctoMapBaseline::~OctoMapBaseline() = default;
OctoMapBaseline::OctoMapBaseline(OctoMapBaseline&&) noexcept = default;
OctoMapBaseline& OctoMapBaseline::operator=(OctoMapBaseline&&) noexcept = default;

void OctoMapBaseline::insert_surface(const Points& points_map) {
  constexpr bool kLazy = true;  // inner nodes once for all points, not once per point
  for (const Eigen::Vector3d& p_map : points_map) {
    tree_->setNodeValue(to_octomap(p_map), tree_->getClampingThresMaxLog(), kLazy);
  }
  tree_->updateInnerOccupancy();
  tree_->prune();
}

void OctoMapBaseline::insert_scan(const Eigen::Vector3d& origin_map, const Points& points_map,
                                  double max_range) {
  prepare_scan(origin_map, points_map, max_range)();
}

std::function<void()> OctoMapBaseline::prepare_scan(const Eigen::Vector3d& origin_map,
                                                    const Points& points_map, double max_range) {
  const auto cloud = std::make_shared<octomap::Pointcloud>();
  cloud->reserve(points_map.size());
  for (const Eigen::Vector3d& p_map : points_map) cloud->push_back(to_octomap(p_map));
  return [&tree = *tree_, origin = to_octomap(origin_map), cloud, max_range] {
    tree.insertPointCloud(*cloud, origin, max_range);
  };
}

bool OctoMapBaseline::occupied(const Eigen::Vector3d& p_map) const {
  const octomap::OcTreeNode* node = tree_->search(to_octomap(p_map));
  return node != nullptr && tree_->isNodeOccupied(node);
}

Points OctoMapBaseline::occupied_centers() const {
  Points centers;
  const double edge = tree_->getResolution();
  for (auto leaf = tree_->begin_leafs(); leaf != tree_->end_leafs(); ++leaf) {
    if (!tree_->isNodeOccupied(*leaf)) continue;
    const int per_edge = 1 << (tree_->getTreeDepth() - leaf.getDepth());
    add_leaf_centers({leaf.getX(), leaf.getY(), leaf.getZ()}, edge, per_edge, centers);
  }
  return centers;
}

std::size_t OctoMapBaseline::memory_bytes() const { return tree_->memoryUsage(); }

std::string OctoMapBaseline::version() { return EVERMAP_OCTOMAP_VERSION; }

}  // namespace evermap
