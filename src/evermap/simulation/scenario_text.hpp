// SPDX-FileCopyrightText: 2026 the evermap authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <sstream>
#include <string>

namespace evermap {

/// A box that stands on the ground, or is lifted above it. Where its numbers are drawn, the braces around
/// them see to the order, which a call's arguments do not have: a seed means the same world with every
/// compiler.
struct Box {
  double x, y, yaw;              ///< [m], [m] and [degrees]
  double length, width, height;  ///< [m]
  double lift = 0;               ///< [m]
};

/// How the robot that drives through a drawn world sees and moves.
struct RandomDrive {
  int channels = 32;             ///< beams of its LiDAR
  int columns = 512;             ///< of each revolution
  int scans = 30;                ///< at 10 Hz
  bool starts_at_speed = false;  ///< else it stands for half a second
  double changed = 0.2;          ///< fraction in [0, 0.5] of the furniture that differs from the survey
};

/// Writes a scenario (docs/scenarios.md), object by object.
class ScenarioText {
 public:
  void box(const Box& box);
  void wall(double x0, double y0, double x1, double y1, double height, double thickness);
  /// Four walls around [-x, x] x [-y, y], seen from within.
  void walls(double x, double y, double height, double thickness);
  void post(double x, double y, double height, double width);
  /// Anything else, by its keys: "body: car, at: [1, 2]".
  void object(const std::string& keys);

  /// The ground's area [-x, x] x [-y, y] and its features: "{slope: [0, 0]}".
  void ground(double x, double y, const std::string& features);
  void sensor_height(double height) { sensor_height_ = height; }
  /// "route: {...}".
  void route(const std::string& keys) { route_ = keys; }

  std::string text(std::uint64_t seed, const RandomDrive& drive) const;

 private:
  int count_ = 0;
  std::ostringstream objects_;
  std::string ground_, route_;
  double sensor_height_ = 1.2;  ///< [m]
};

std::string text_of(const Box& box);

}  // namespace evermap
