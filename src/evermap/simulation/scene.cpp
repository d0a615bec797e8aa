// SPDX-FileCopyrightText: 2026 the evermap authors
// SPDX-License-Identifier: BSD-3-Clause
#include <algorithm>
#include <cmath>
#include <numbers>

#include <evermap/simulation/scene.hpp>
#include <evermap/simulation/surface_index.hpp>
#include <evermap/simulation/terrain.hpp>

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

Eigen::Vector2d polar(double radius, double angle) {
  return radius * Eigen::Vector2d(std::cos(angle), std::sin(angle));
}

/// How a round surface is divided.
struct Disc {
  std::uint32_t rings;
  std::uint32_t sectors;
};

/// Adds a surface whose point at a share of its radius and an angle [rad] is `vertex_at(share, angle)`.
template <class VertexAt>
void add_disc(Scene& scene, int object, const Disc& disc, const VertexAt& vertex_at) {
  const auto top = static_cast<std::uint32_t>(scene.vertices.size());
  scene.vertices.push_back(vertex_at(0.0, 0.0));
  for (std::uint32_t ring = 1; ring <= disc.rings; ++ring) {
    for (std::uint32_t sector = 0; sector < disc.sectors; ++sector) {
      scene.vertices.push_back(
          vertex_at(static_cast<double>(ring) / disc.rings, 2 * std::numbers::pi * sector / disc.sectors));
    }
  }
  const auto vertex = [&](std::uint32_t ring, std::uint32_t sector) {
    return top + 1 + (ring - 1) * disc.sectors + sector % disc.sectors;
  };
  for (std::uint32_t sector = 0; sector < disc.sectors; ++sector) {
    add_triangle(scene, object, top, vertex(1, sector), vertex(1, sector + 1));
    for (std::uint32_t ring = 1; ring < disc.rings; ++ring) {
      add_quad(scene, object,
               {vertex(ring, sector), vertex(ring + 1, sector), vertex(ring + 1, sector + 1),
                vertex(ring, sector + 1)});
    }
  }
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
  constexpr Disc kDisc{16, 48};
  add_disc(scene, object, kDisc, [&](double share_of_radius, double angle) {
    const Eigen::Vector2d p = heap.center + polar(share_of_radius * heap.radius, angle);
    const double rise = 0.5 * heap.height * (1 + std::cos(std::numbers::pi * share_of_radius));
    return Eigen::Vector3d(p.x(), p.y(), ground(p.x(), p.y()) + rise);
  });
}

void add_pile(Scene& scene, int object, const Pile& pile, const HeightFunction& ground) {
  constexpr double kTip = 0.3;    ///< [m] radius of the blunt tip
  constexpr double kStep = 0.4;   ///< [m] between vertices, about
  constexpr double kSkirt = 1.0;  ///< [m] down to which the ground may fall away
  const double grade = std::tan(pile.repose);
  const double top = ground(pile.center.x(), pile.center.y()) + pile.height;
  const double radius = (pile.height + kSkirt) / grade + kTip;
  const HeightFunction bumps = roughness({pile.roughness, 2 * kStep, pile.seed});
  const Disc disc{static_cast<std::uint32_t>(std::ceil(radius / kStep)),
                  static_cast<std::uint32_t>(std::ceil(2 * std::numbers::pi * radius / kStep))};
  add_disc(scene, object, disc, [&](double share_of_radius, double angle) {
    const double r = share_of_radius * radius;
    const Eigen::Vector2d p = pile.center + polar(r, angle);
    const double fall = grade * (std::hypot(r, kTip) - kTip);
    return Eigen::Vector3d(p.x(), p.y(), top - fall + bumps(p.x(), p.y()));
  });
}

void add_mesh(Scene& scene, int object, const Pose& T_map_mesh, const TriangleMesh& mesh) {
  const auto first = static_cast<std::uint32_t>(scene.vertices.size());
  for (const Eigen::Vector3d& p_mesh : mesh.vertices) scene.vertices.push_back(T_map_mesh * p_mesh);
  for (const auto& [a, b, c] : mesh.triangles) add_triangle(scene, object, first + a, first + b, first + c);
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
