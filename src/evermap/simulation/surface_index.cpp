// SPDX-FileCopyrightText: 2026 the evermap authors
// SPDX-License-Identifier: BSD-3-Clause
#include <algorithm>
#include <cmath>
#include <limits>

#include <evermap/simulation/surface_index.hpp>

namespace evermap {
namespace {

/// [m] Surfaces nearer than this count as touching: a box's bottom on the ground.
constexpr double kTouching = 1e-6;

/// +1 where a half line from `p` straight up leaves the solid of this triangle, -1 where it enters, else 0.
int crossing_above(const Triangle3& triangle, const Eigen::Vector3d& p) {
  const Triangle2 outline{triangle.a.head<2>(), triangle.b.head<2>(), triangle.c.head<2>()};
  if (!outline.covers(p.head<2>())) return 0;
  const Eigen::Vector3d normal = triangle.scaled_normal();
  if (std::abs(normal.z()) <= 1e-9 * normal.norm()) return 0;  // upright: met edge-on
  const double height =
      triangle.a.z() - p.z() - normal.head<2>().dot((p - triangle.a).head<2>()) / normal.z();
  if (normal.z() > 0) return height >= -kTouching ? 1 : 0;
  return height > kTouching ? -1 : 0;
}

}  // namespace

SurfaceIndex::SurfaceIndex(const Scene& scene) : scene_(&scene) {
  for (const Eigen::Vector3d& vertex : scene.vertices) bounds_.extend(vertex.head<2>());
  if (scene.triangles.empty()) return;
  const Eigen::Vector2d size = bounds_.sizes();
  // About two triangles per bin of a scene that is spread evenly.
  bin_edge_ = std::max(std::sqrt(2 * size.x() * size.y() / static_cast<double>(scene.triangles.size())),
                       1e-3 * size.maxCoeff());
  bins_ = (size / bin_edge_).array().floor().cast<int>() + 1;
  triangles_.resize(static_cast<std::size_t>(bins_.prod()));
  for (std::size_t i = 0; i < scene.triangles.size(); ++i) {
    const Triangle3 triangle = scene.triangle(i);
    const Bin low = bin(triangle.a.cwiseMin(triangle.b).cwiseMin(triangle.c).head<2>());
    const Bin high = bin(triangle.a.cwiseMax(triangle.b).cwiseMax(triangle.c).head<2>());
    for (int y = low.y(); y <= high.y(); ++y) {
      for (int x = low.x(); x <= high.x(); ++x) {
        triangles_[slot({x, y})].push_back(static_cast<std::uint32_t>(i));
      }
    }
  }
}

SurfaceIndex::Bin SurfaceIndex::bin(const Eigen::Vector2d& p) const {
  return ((p - bounds_.min()) / bin_edge_).array().floor().cast<int>();
}

std::size_t SurfaceIndex::slot(const Bin& bin) const {
  return static_cast<std::size_t>(bin.y()) * static_cast<std::size_t>(bins_.x()) +
         static_cast<std::size_t>(bin.x());
}

bool SurfaceIndex::buried(const Eigen::Vector3d& p_map, std::optional<int> except) const {
  if (!bounds_.contains(p_map.head<2>())) return false;
  // Every solid contributes 1 when the point is inside and 0 when not, so that the solids need no telling
  // apart.
  int inside = 0;
  for (const std::uint32_t i : triangles_[slot(bin(p_map.head<2>()))]) {
    if (scene_->object[i] != except) inside += crossing_above(scene_->triangle(i), p_map);
  }
  return inside > 0;
}

double SurfaceIndex::distance(const Eigen::Vector3d& p_map, double limit) const {
  double nearest = std::numeric_limits<double>::infinity();
  const Eigen::Vector2d reach = Eigen::Vector2d::Constant(limit);
  const Eigen::AlignedBox2d area =
      bounds_.intersection(Eigen::AlignedBox2d(p_map.head<2>() - reach, p_map.head<2>() + reach));
  if (triangles_.empty() || area.isEmpty()) return nearest;
  const Bin low = bin(area.min());
  const Bin high = bin(area.max());
  for (int y = low.y(); y <= high.y(); ++y) {
    for (int x = low.x(); x <= high.x(); ++x) {
      for (const std::uint32_t i : triangles_[slot({x, y})]) {
        nearest = std::min(nearest, (scene_->triangle(i).closest_point(p_map) - p_map).norm());
      }
    }
  }
  return nearest <= limit ? nearest : std::numeric_limits<double>::infinity();
}

}  // namespace evermap
