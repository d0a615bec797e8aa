// SPDX-FileCopyrightText: 2026 the evermap authors
// SPDX-License-Identifier: BSD-3-Clause
#include <algorithm>
#include <cmath>
#include <numbers>
#include <stdexcept>

#include <evermap/simulation/route.hpp>

namespace evermap {
namespace {

double yaw_of(const Eigen::Vector2d& direction) { return std::atan2(direction.y(), direction.x()); }

/// The same angle in [-pi, pi].
double wrapped(double angle) { return std::remainder(angle, 2 * std::numbers::pi); }

void check(const std::vector<Route::Waypoint>& waypoints, bool loops) {
  if (waypoints.size() < 2) throw std::invalid_argument("a route needs at least two waypoints");
  for (std::size_t i = 0; i < waypoints.size(); ++i) {
    const bool has_next = loops || i + 1 < waypoints.size();
    if (has_next && waypoints[i].xy == waypoints[(i + 1) % waypoints.size()].xy) {
      throw std::invalid_argument("two waypoints one after the other are at the same place");
    }
    if (!(waypoints[i].speed > 0)) throw std::invalid_argument("a speed must be above 0");
    if (!(waypoints[i].wait >= 0)) throw std::invalid_argument("a wait must not be negative");
  }
}

}  // namespace

/// How a waypoint is rounded: the arc leaves the line `cut` [m] before it and meets the next as much behind.
struct Route::Corner {
  double cut = 0;        ///< [m]
  double curvature = 0;  ///< [1/m]
  double half_arc = 0;   ///< [m]

  Corner() = default;
  /// `room` [m] is what the lines on both sides can give.
  Corner(const Eigen::Vector2d& before, const Eigen::Vector2d& at, const Eigen::Vector2d& after,
         double radius, double room) {
    const double turn = wrapped(yaw_of(after - at) - yaw_of(at - before));
    // Who turns right back does so on the spot.
    if (std::abs(turn) > 0.95 * std::numbers::pi) return;
    const double bend = std::tan(std::abs(turn) / 2);
    cut = std::min(radius * bend, room);
    if (cut <= 0) return;
    curvature = std::copysign(bend / cut, turn);
    half_arc = std::abs(turn / curvature) / 2;
  }
};

Place Route::Piece::at(double distance) const {
  const double turn = curvature * distance;
  // The chord of an arc: its length is that of the arc times sin(x) / x of half the turn.
  const double half = turn / 2;
  const double chord = std::abs(half) < 1e-9 ? distance : distance * std::sin(half) / half;
  return {from.xy + chord * Eigen::Vector2d(std::cos(from.yaw + half), std::sin(from.yaw + half)),
          wrapped(from.yaw + turn)};
}

Place Route::Leg::at(double time) const {
  const double elapsed = std::clamp(time, begin, end) - begin;
  const double gained = (speed_end - speed_begin) * elapsed / (end - begin);
  double distance = elapsed * (speed_begin + gained / 2);
  for (const Piece& piece : pieces) {
    if (distance < piece.length) return piece.at(distance);
    distance -= piece.length;
  }
  return pieces.back().at(pieces.back().length);
}

Route::Leg Route::leg(const Waypoint& from, const Corner& out, const Waypoint& to, const Corner& in,
                      double arrival) {
  const Eigen::Vector2d line = to.xy - from.xy;
  const Eigen::Vector2d ahead = line.normalized();
  const double straight = std::max(0.0, line.norm() - out.cut - in.cut);
  // The half arc behind the waypoint, run backwards from where it meets the line.
  const Piece back{{from.xy + out.cut * ahead, yaw_of(-ahead)}, out.half_arc, -out.curvature};
  Place middle = back.at(out.half_arc);
  middle.yaw = wrapped(middle.yaw + std::numbers::pi);
  const Piece arc_out{middle, out.half_arc, out.curvature};
  const Piece onward{{from.xy + out.cut * ahead, yaw_of(ahead)}, straight, 0};
  const Piece arc_in{onward.at(straight), in.half_arc, in.curvature};
  const double length = out.half_arc + straight + in.half_arc;
  const double begin = arrival + from.wait;
  const double drive = 2 * length / (from.speed + to.speed);
  return {{arc_out, onward, arc_in}, length, from.speed, to.speed, begin, begin + drive};
}

Route::Route(std::vector<Waypoint> waypoints, double turn_radius, double start, End end)
    : start_(start), end_(end) {
  const bool loops = end == End::kLoop;
  check(waypoints, loops);
  if (!(turn_radius >= 0)) throw std::invalid_argument("a turn radius must not be negative");
  if (!(start >= 0)) throw std::invalid_argument("a start must not be negative");
  const std::size_t n = waypoints.size();
  std::vector<Corner> corners(n);
  // A line between two corners is shared by them; the first and the last of an open route has only one.
  const auto room = [&](std::size_t from) {
    const double line = (waypoints[(from + 1) % n].xy - waypoints[from].xy).norm();
    return !loops && (from == 0 || from + 2 == n) ? line : line / 2;
  };
  for (std::size_t i = loops ? 0 : 1; i < (loops ? n : n - 1); ++i) {
    const std::size_t before = (i + n - 1) % n;
    corners[i] = Corner(waypoints[before].xy, waypoints[i].xy, waypoints[(i + 1) % n].xy, turn_radius,
                        std::min(room(before), room(i)));
  }
  for (std::size_t i = 0; i < (loops ? n : n - 1); ++i) {
    const std::size_t next = (i + 1) % n;
    legs_.push_back(leg(waypoints[i], corners[i], waypoints[next], corners[next], duration_));
    length_ += legs_.back().length;
    duration_ = legs_.back().end;
  }
  if (!loops) duration_ += waypoints.back().wait;
}

std::optional<Place> Route::at(double time) const {
  double elapsed = time - start_;
  if (end_ == End::kVanish && (elapsed < 0 || elapsed >= duration_)) return std::nullopt;
  if (end_ == End::kLoop && elapsed > 0) elapsed = std::fmod(elapsed, duration_);
  // Before a leg begins, its first point: that is where one waits.
  const auto leg = std::find_if(legs_.begin(), legs_.end() - 1,
                                [&](const Leg& candidate) { return elapsed < candidate.end; });
  return leg->at(elapsed);
}

}  // namespace evermap
