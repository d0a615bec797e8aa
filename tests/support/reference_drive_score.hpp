// SPDX-FileCopyrightText: 2026 the evermap authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cmath>
#include <string>
#include <vector>

#include <Eigen/Geometry>

#include <evermap/evaluation/labelled_drive.hpp>

namespace evermap::test {

/// The drive's score once more, written from its description alone: to be inside a box is to
/// be on the inner side of all six faces, and every point is judged by rules in words.
class ReferenceDriveScore {
 public:
  std::size_t static_points = 0, static_claimed = 0;
  std::size_t seen_points = 0, seen_claimed = 0;
  std::size_t parked_points = 0, parked_claimed = 0;
  std::size_t moving_points = 0, moving_claimed = 0;

  void add(const Scan& scan, const Pose& T_map_sensor, const std::vector<LabelledBox>& boxes, bool is_last,
           const Claim& claim) {
    for (const Eigen::Vector3d& p : scan.p_sensor) {
      const std::string kind = kind_of(p, boxes);
      const bool claimed = claim(T_map_sensor * p);
      if (kind == "static") tally(claimed, static_points, static_claimed);
      if (kind == "static" && is_in_view(p)) tally(claimed, seen_points, seen_claimed);
      if (kind == "parked") tally(claimed, parked_points, parked_claimed);
      if (kind == "moving" && !is_last) tally(claimed, moving_points, moving_claimed);
    }
  }

  static std::string kind_of(const Eigen::Vector3d& p, const std::vector<LabelledBox>& boxes) {
    if (std::sqrt(p.x() * p.x() + p.y() * p.y() + p.z() * p.z()) < 2.5) return "excluded";
    std::vector<LabelledBox> around;
    for (const LabelledBox& box : boxes) {
      if (contains(box, p)) around.push_back(box);
    }
    // The first box that says more than "parked" decides.
    for (const LabelledBox& box : around) {
      if (box.motion == LabelledBox::Motion::kUncertain) return "excluded";
      if (box.motion != LabelledBox::Motion::kMoving) continue;
      const double bottom = box.center_sensor.z() - box.size.z() / 2;
      return p.z() - bottom < 0.15 ? "excluded" : "moving";
    }
    return around.empty() ? "static" : "parked";
  }

 private:
  static void tally(bool is_claimed, std::size_t& points, std::size_t& claimed) {
    ++points;
    if (is_claimed) ++claimed;
  }

  /// The camera that was labelled looks forward and sees 40 degrees to either side.
  static bool is_in_view(const Eigen::Vector3d& p) {
    const double slope = 0.839;
    return p.x() > 0 && p.y() < slope * p.x() && p.y() > -slope * p.x();
  }

  static bool contains(const LabelledBox& box, const Eigen::Vector3d& p) {
    const Eigen::Matrix3d axes(Eigen::AngleAxisd(box.yaw, Eigen::Vector3d::UnitZ()));
    for (int axis = 0; axis < 3; ++axis) {
      for (const int side : {-1, 1}) {
        const Eigen::Vector3d outward = side * axes.col(axis);
        const Eigen::Vector3d on_face = box.center_sensor + outward * (box.size[axis] / 2 + 0.1);
        if ((p - on_face).dot(outward) > 0) return false;
      }
    }
    return true;
  }
};

}  // namespace evermap::test
