// SPDX-FileCopyrightText: 2026 the evermap authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <array>
#include <cstdint>
#include <string>
#include <string_view>

namespace evermap {

/// Kinds of places that a robot may have to find its way in.
inline constexpr std::array<std::string_view, 11> kWorldKinds = {
    "room",   "corridor", "tunnel", "hall",    "warehouse", "containers",
    "street", "forest",   "quarry", "parking", "floors"};

/// How the robot that drives through a random world sees and moves.
struct RandomDrive {
  int channels = 32;             ///< beams of its LiDAR
  int columns = 512;             ///< of each revolution
  int scans = 30;                ///< at 10 Hz
  bool starts_at_speed = false;  ///< else it stands for half a second
  double changed = 0.2;          ///< fraction in [0, 0.5] of the furniture that differs from the survey
};

/// A world of this kind as the text of a scenario (docs/scenarios.md), with a drive of some seconds in the
/// middle of it. The same seed gives the same text. REQUIRES: kind is one of kWorldKinds.
std::string random_world(std::string_view kind, std::uint64_t seed, const RandomDrive& drive);

}  // namespace evermap
