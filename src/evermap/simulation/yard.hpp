// SPDX-FileCopyrightText: 2026 the evermap authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <vector>

#include <evermap/geometry/pose.hpp>
#include <evermap/simulation/scene.hpp>

namespace evermap {

/// A small world to show and test map maintenance in: a walled yard of 60 m x 60 m on undulating ground, with
/// containers and posts, before and after four changes, and a drive through it after them.
struct Yard {
  // Object ids of what changed.
  static constexpr int kVanished = 100;  ///< a box, in `before` only
  static constexpr int kAppeared = 101;  ///< a box, in `now` only
  static constexpr int kMoved = 102;     ///< a box, shifted by 0.25 m along its length
  static constexpr int kHeap = 103;      ///< grown from 1.2 m high, 3 m radius to 1.8 m, 3.8 m

  Scene before;
  Scene now;
  std::vector<Pose> T_map_sensor;  ///< 60 poses, 0.1 s apart, 1.7 m above the ground, at 2 to 5 m/s
};

/// The same yard every time.
Yard make_yard();

}  // namespace evermap
