// SPDX-FileCopyrightText: 2026 the evermap authors
// SPDX-License-Identifier: BSD-3-Clause
#include <algorithm>
#include <cmath>
#include <numbers>

#include <evermap/simulation/scene.hpp>
#include <evermap/simulation/surface_index.hpp>

namespace evermap {
namespace {

void add_triangle(Scene& scene, int object, std::uint32_t a, std::uint32_t b, std::uint32_t c) {
  scene.triangles.push_back({a, b, c});
  scene.object.push_back(object);
}

/// Adds the quadrilateral a b c d, counter-clockwise seen from outside.
void add_quad(Scene& scene, int object, const std::array<std::uint32_t, 4>& q) {
  add_triangle(scene, object, q[0], q[1], q[2]);
  add_triangle(scene, object, q[0], q[2], q[3]);
}

/// Two axes that span the plane across `normal`; planes of like normals get like axes, so that the lattices
/// of neighbouring triangles fit together.
std::array<Eigen::Vector3d, 2> plane_axes(const Eigen::Vector3d& normal) {
  const Eigen::Vector3d reference =
      std::abs(normal.x()) < 0.7 * normal.norm() ? Eigen::Vector3d::UnitX() : Eigen::Vector3d::UnitY();
  const Eigen::Vector3d v = normal.cross(reference).normalized();
  return {v.cross(normal).normalized(), v};
}

void sample_triangle(const Triangle3& triangle, double spacing, std::vector<Eigen::Vector3d>& samples) {
  const Eigen::Vector3d normal = triangle.scaled_normal().normalized();
  const std::array<Eigen::Vector3d, 2> axes = plane_axes(normal);
  const Eigen::Vector3d& u = axes[0];
  const Eigen::Vector3d& v = axes[1];
  const auto flat = [&](const Eigen::Vector3d& p) {
    return Eigen::Vector2d(u.dot(p) / spacing, v.dot(p) / spacing);
  };
  const Triangle2 outline{flat(triangle.a), flat(triangle.b), flat(triangle.c)};
  const Eigen::Vector2i low = outline.a.cwiseMin(outline.b).cwiseMin(outline.c).array().floor().cast<int>();
  const Eigen::Vector2i high = outline.a.cwiseMax(outline.b).cwiseMax(outline.c).array().floor().cast<int>();
  for (int i = low.x(); i <= high.x(); ++i) {
    for (int j = low.y(); j <= high.y(); ++j) {
      // Half a step from the world's axes, where the edges of things like to be.
      const Eigen::Vector2d p(i + 0.5, j + 0.5);
      if (!outline.covers(p)) continue;
      samples.emplace_back(spacing * (p.x() * u + p.y() * v) + normal * normal.dot(triangle.a));
    }
  }
}

}  // namespace

void add_ground(Scene& scene, int object, const Eigen::AlignedBox2d& area, double spacing,
                const HeightFunction& height) {
  const Eigen::Vector2d size = area.sizes();
  const auto columns = static_cast<std::uint32_t>(std::ceil(size.x() / spacing));
  const auto rows = static_cast<std::uint32_t>(std::ceil(size.y() / spacing));
  const auto first = static_cast<std::uint32_t>(scene.vertices.size());
  for (std::uint32_t row = 0; row <= rows; ++row) {
    for (std::uint32_t column = 0; column <= columns; ++column) {
      const double x = area.min().x() + size.x() * column / columns;
      const double y = area.min().y() + size.y() * row / rows;
      scene.vertices.emplace_back(x, y, height(x, y));
    }
  }
  for (std::uint32_t row = 0; row < rows; ++row) {
    for (std::uint32_t column = 0; column < columns; ++column) {
      const std::uint32_t corner = first + row * (columns + 1) + column;
      add_quad(scene, object, {corner, corner + 1, corner + columns + 2, corner + columns + 1});
    }
  }
}

void add_box(Scene& scene, int object, const Pose& T_map_box, const Eigen::Vector3d& size) {
  const auto first = static_cast<std::uint32_t>(scene.vertices.size());
  for (int corner = 0; corner < 8; ++corner) {
    const Eigen::Vector3d sign((corner & 1) ? 1 : -1, (corner & 2) ? 1 : -1, (corner & 4) ? 1 : -1);
    scene.vertices.push_back(T_map_box * (0.5 * sign.cwiseProduct(size)));
  }
  constexpr std::array<std::array<std::uint32_t, 4>, 6> kFaces{
      {{0, 2, 3, 1}, {4, 5, 7, 6}, {0, 1, 5, 4}, {2, 6, 7, 3}, {0, 4, 6, 2}, {1, 3, 7, 5}}};
  for (auto face : kFaces) {
    for (auto& corner : face) corner += first;
    add_quad(scene, object, face);
  }
}

void add_heap(Scene& scene, int object, const Heap& heap, const HeightFunction& ground) {
  constexpr std::uint32_t kRings = 16;
  constexpr std::uint32_t kSectors = 48;
  const auto top = static_cast<std::uint32_t>(scene.vertices.size());
  const auto add_vertex = [&](double share_of_radius, double angle) {
    const Eigen::Vector2d p =
        heap.center + share_of_radius * heap.radius * Eigen::Vector2d(std::cos(angle), std::sin(angle));
    const double rise = 0.5 * heap.height * (1 + std::cos(std::numbers::pi * share_of_radius));
    scene.vertices.emplace_back(p.x(), p.y(), ground(p.x(), p.y()) + rise);
  };
  add_vertex(0, 0);
  for (std::uint32_t ring = 1; ring <= kRings; ++ring) {
    for (std::uint32_t sector = 0; sector < kSectors; ++sector) {
      add_vertex(static_cast<double>(ring) / kRings, 2 * std::numbers::pi * sector / kSectors);
    }
  }
  const auto vertex = [&](std::uint32_t ring, std::uint32_t sector) {
    return top + 1 + (ring - 1) * kSectors + sector % kSectors;
  };
  for (std::uint32_t sector = 0; sector < kSectors; ++sector) {
    add_triangle(scene, object, top, vertex(1, sector), vertex(1, sector + 1));
    for (std::uint32_t ring = 1; ring < kRings; ++ring) {
      add_quad(scene, object,
               {vertex(ring, sector), vertex(ring + 1, sector), vertex(ring + 1, sector + 1),
                vertex(ring, sector + 1)});
    }
  }
}

std::vector<SurfaceSample> sample_surface(const Scene& scene, double spacing) {
  const SurfaceIndex index(scene);
  std::vector<SurfaceSample> visible;
  std::vector<Eigen::Vector3d> samples;
  for (std::size_t i = 0; i < scene.triangles.size(); ++i) {
    samples.clear();
    sample_triangle(scene.triangle(i), spacing, samples);
    for (const Eigen::Vector3d& p_map : samples) {
      if (!index.buried(p_map, scene.object[i])) visible.push_back({p_map, scene.object[i]});
    }
  }
  return visible;
}

}  // namespace evermap
