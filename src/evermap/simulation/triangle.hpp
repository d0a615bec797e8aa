// SPDX-FileCopyrightText: 2026 the evermap authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <algorithm>

#include <Eigen/Core>
#include <Eigen/Geometry>

namespace evermap {

struct Triangle2 {
  Eigen::Vector2d a, b, c;

  /// True when `p` is inside. Half-open: a point on an edge shared by two triangles is inside exactly one of
  /// them, so that a tessellated surface has neither gaps nor double cover.
  bool covers(const Eigen::Vector2d& p) const {
    return (right_of(p, a, b) + right_of(p, b, c) + right_of(p, c, a)) % 2 == 1;
  }

 private:
  /// 1 when the edge from..to crosses the half line from `p` towards +x. The edge is always evaluated
  /// upwards, so that both its triangles round alike.
  static int right_of(const Eigen::Vector2d& p, Eigen::Vector2d from, Eigen::Vector2d to) {
    if ((from.y() > p.y()) == (to.y() > p.y())) return 0;
    if (from.y() > to.y()) std::swap(from, to);
    const Eigen::Vector2d edge = to - from;
    const Eigen::Vector2d to_p = p - from;
    return edge.x() * to_p.y() - edge.y() * to_p.x() > 0 ? 1 : 0;
  }
};

/// A triangle whose corners run counter-clockwise seen from outside.
struct Triangle3 {
  Eigen::Vector3d a, b, c;

  /// Outward normal, as long as twice the area.
  Eigen::Vector3d scaled_normal() const { return (b - a).cross(c - a); }

  /// The point of the triangle nearest to `p`. REQUIRES: the triangle is not degenerate.
  Eigen::Vector3d closest_point(const Eigen::Vector3d& p) const {
    const Eigen::Vector3d n = scaled_normal();
    const bool inside = (b - a).cross(p - a).dot(n) >= 0 && (c - b).cross(p - b).dot(n) >= 0 &&
                        (a - c).cross(p - c).dot(n) >= 0;
    if (inside) return p - n * (n.dot(p - a) / n.squaredNorm());
    Eigen::Vector3d best = closest_on_edge(p, a, b);
    for (const Eigen::Vector3d& candidate : {closest_on_edge(p, b, c), closest_on_edge(p, c, a)}) {
      if ((candidate - p).squaredNorm() < (best - p).squaredNorm()) best = candidate;
    }
    return best;
  }

 private:
  static Eigen::Vector3d closest_on_edge(const Eigen::Vector3d& p, const Eigen::Vector3d& from,
                                         const Eigen::Vector3d& to) {
    const Eigen::Vector3d edge = to - from;
    return from + std::clamp((p - from).dot(edge) / edge.squaredNorm(), 0.0, 1.0) * edge;
  }
};

}  // namespace evermap
