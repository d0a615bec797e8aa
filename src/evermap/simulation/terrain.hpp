// SPDX-FileCopyrightText: 2026 the evermap authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <limits>
#include <vector>

#include <Eigen/Core>

#include <evermap/simulation/route.hpp>
#include <evermap/simulation/scene.hpp>

namespace evermap {

// The features whose sum is the height of the ground.

/// A plane through the origin that rises by `grade` [m/m] along x and y.
HeightFunction slope(const Eigen::Vector2d& grade);

struct Waves {
  double amplitude;        ///< [m]
  Eigen::Vector2d length;  ///< [m] along x and y; infinity: the same all along
  double phase = 0;        ///< [rad] along x
};
/// A sine along x times a cosine along y.
HeightFunction waves(const Waves& waves);

struct Roughness {
  double amplitude;        ///< [m] largest deviation to either side
  double size;             ///< [m] between neighbouring bumps
  std::uint64_t seed = 1;  ///< another seed gives other bumps
};
/// Smooth random bumps.
HeightFunction roughness(const Roughness& roughness);

/// The wall of a pit: benches that rise around a rectangle with rounded corners.
struct Terraces {
  Eigen::Vector2d center;  ///< [m]
  Eigen::Vector2d size;    ///< [m] of the floor
  double corner;           ///< [m] radius of the corners
  int count;               ///< benches
  double height;           ///< [m] of each
  double face;             ///< [m] that a face leans back
  double width;            ///< [m] of the level part between two faces
  double wobble = 0;       ///< [m] by which the edges leave their line to either side
};
HeightFunction terraces(const Terraces& terraces);

/// A bank along a line of straight pieces; with a negative height, a ditch.
struct Embankment {
  std::vector<Eigen::Vector2d> line;  ///< [m] at least two points
  double height;                      ///< [m]
  double width;                       ///< [m] of the level crown
  double side;                        ///< [m] that each side takes to come down
};
HeightFunction embankment(const Embankment& embankment);

HeightFunction sum(std::vector<HeightFunction> features);

/// The frame of something that stands on the ground with four feet `reach` [m] before, behind, left and right
/// of its middle: x along the yaw, z along the feet's normal. REQUIRES: reach > 0.
Pose standing_pose(const HeightFunction& ground, const Place& at, double reach);

}  // namespace evermap
