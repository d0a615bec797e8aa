// SPDX-FileCopyrightText: 2026 the evermap authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <vector>

#include <Eigen/Core>
#include <Eigen/Geometry>

#include <evermap/geometry/pose.hpp>
#include <evermap/simulation/triangle.hpp>

namespace evermap {

/// The world that a simulated LiDAR looks at: opaque solids given by their triangles, in the map frame.
///
/// Class invariant: `object` has one entry per triangle; corners run counter-clockwise seen from outside
/// (from above for ground and heaps, which are open below and count as solid there); every solid has an id of
/// its own, and the same thing in two scenes has the same id.
struct Scene {
  std::vector<Eigen::Vector3d> vertices;                ///< [m]
  std::vector<std::array<std::uint32_t, 3>> triangles;  ///< indices of vertices
  std::vector<int> object;                              ///< id of the solid that each triangle belongs to

  Triangle3 triangle(std::size_t index) const {
    const auto& corner = triangles[index];
    return {vertices[corner[0]], vertices[corner[1]], vertices[corner[2]]};
  }
};

/// Height z [m] at (x, y) [m].
using HeightFunction = std::function<double(double, double)>;

/// Adds ground over `area`, sampled on a grid at most `spacing` [m] wide.
void add_ground(Scene& scene, int object, const Eigen::AlignedBox2d& area, double spacing,
                const HeightFunction& height);

/// Adds a box of edge lengths `size` [m] whose center is the origin of the box frame.
void add_box(Scene& scene, int object, const Pose& T_map_box, const Eigen::Vector3d& size);

/// A smooth round bump, half a wave of a cosine: it leaves the ground and reaches its top without an edge.
struct Heap {
  Eigen::Vector2d center;  ///< [m]
  double radius;           ///< [m] where it meets the ground
  double height;           ///< [m] of the top above the ground
};

/// Adds a heap that lies on `ground`.
void add_heap(Scene& scene, int object, const Heap& heap, const HeightFunction& ground);

/// Poured gravel: a cone as steep as loose material can lie, its tip blunt, its skin rough.
struct Pile {
  Eigen::Vector2d center;  ///< [m]
  double height;           ///< [m] of the top above the ground there, > 0
  double repose;           ///< [rad] angle to the level, in (0, pi/2)
  double roughness = 0;    ///< [m] largest deviation to either side
  std::uint64_t seed = 1;  ///< of the roughness, which belongs to the place: a growing pile keeps its bumps
};

/// Adds a pile that lies on `ground`, however that slopes: its skirt goes on below the ground.
void add_pile(Scene& scene, int object, const Pile& pile, const HeightFunction& ground);

/// The surface of a thing of any shape, in a frame of its own: [m], triangles counter-clockwise seen from
/// outside, indices below the number of vertices.
struct TriangleMesh {
  std::vector<Eigen::Vector3d> vertices;
  std::vector<std::array<std::uint32_t, 3>> triangles;
};

void add_mesh(Scene& scene, int object, const Pose& T_map_mesh, const TriangleMesh& mesh);

/// A point of a surface.
struct SurfaceSample {
  Eigen::Vector3d p_map;  ///< [m]
  int object;             ///< id of the solid
};

/// Points of all surfaces that a sensor may see, on a lattice `spacing` [m] wide in the plane of each
/// triangle. What lies inside another solid (the ground under a box, the box's bottom) is left out. The same
/// scene gives the same samples.
std::vector<SurfaceSample> sample_surface(const Scene& scene, double spacing);

}  // namespace evermap
