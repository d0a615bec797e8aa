// SPDX-FileCopyrightText: 2026 the evermap authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <array>
#include <cstddef>
#include <optional>
#include <vector>

#include <Eigen/Core>

namespace evermap {

/// Where something stands, seen from above.
struct Place {
  Eigen::Vector2d xy = Eigen::Vector2d::Zero();  ///< [m] map frame
  double yaw = 0;                                ///< [rad] counter-clockwise from x
};

/// A way through the world in time: straight lines between waypoints, with corners rounded to arcs.
///
/// Between two waypoints the acceleration is constant; a wait is a full stop without braking. Thread safe.
class Route {
 public:
  struct Waypoint {
    Eigen::Vector2d xy;  ///< [m] map frame; a corner's arc passes beside it
    double speed;        ///< [m/s] > 0, when passing
    double wait = 0;     ///< [s] before going on
  };
  enum class End {
    kLoop,   ///< back to the first waypoint and on for ever
    kStay,   ///< stands at the last waypoint
    kVanish  ///< is there between start and end only
  };

  /// Arcs have `turn_radius` [m], less where lines are too short for it. The first waypoint is left `start`
  /// [s] after time 0. Throws std::invalid_argument for fewer than two waypoints, neighbours at one place, a
  /// speed that is not positive, or a negative wait, radius or start.
  Route(std::vector<Waypoint> waypoints, double turn_radius, double start, End end);

  /// Where to be at `time` [s]; none when not there.
  std::optional<Place> at(double time) const;

  double length() const { return length_; }      ///< [m] once through
  double duration() const { return duration_; }  ///< [s] once through, waits included

 private:
  /// A piece of constant curvature.
  struct Piece {
    Place from;
    double length;     ///< [m]
    double curvature;  ///< [1/m] positive to the left
    Place at(double distance) const;
  };
  /// From one waypoint to the next: half a corner, a straight line, half a corner.
  struct Leg {
    std::array<Piece, 3> pieces;
    double length;       ///< [m]
    double speed_begin;  ///< [m/s]
    double speed_end;    ///< [m/s]
    double begin;        ///< [s] since the route's start
    double end;          ///< [s]
    Place at(double time) const;
  };

  struct Corner;
  static Leg leg(const Waypoint& from, const Corner& out, const Waypoint& to, const Corner& in,
                 double arrival);

  std::vector<Leg> legs_;
  double start_;
  double length_ = 0;
  double duration_ = 0;
  End end_;
};

}  // namespace evermap
