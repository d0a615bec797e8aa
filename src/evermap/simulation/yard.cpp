// SPDX-FileCopyrightText: 2026 the evermap authors
// SPDX-License-Identifier: BSD-3-Clause
#include <algorithm>
#include <cmath>
#include <numbers>

#include <evermap/simulation/yard.hpp>

namespace evermap {
namespace {

constexpr int kGround = 0;

/// Slopes of up to 5 %: no plane of the ground is aligned with voxels.
double ground_height(double x, double y) {
  return 0.02 * x + 0.01 * y + 0.15 * std::sin(0.21 * x + 0.4) * std::cos(0.17 * y);
}

Eigen::Vector3d ground_normal(double x, double y) {
  constexpr double kStep = 1e-3;
  const double slope_x = (ground_height(x + kStep, y) - ground_height(x - kStep, y)) / (2 * kStep);
  const double slope_y = (ground_height(x, y + kStep) - ground_height(x, y - kStep)) / (2 * kStep);
  return Eigen::Vector3d(-slope_x, -slope_y, 1).normalized();
}

struct Footprint {
  double x, y;           ///< [m] center
  double yaw;            ///< [rad]
  double length, width;  ///< [m]
};

/// Adds an upright box that rises `height` [m] above the ground at its center and goes `depth` [m] below it,
/// enough for its whole bottom to be in the ground.
void add_standing_box(Scene& scene, int object, const Footprint& at, double height, double depth = 0.4) {
  Pose T_map_box;
  T_map_box.rotation = Eigen::AngleAxisd(at.yaw, Eigen::Vector3d::UnitZ()).toRotationMatrix();
  T_map_box.translation = {at.x, at.y, ground_height(at.x, at.y) + 0.5 * (height - depth)};
  add_box(scene, object, T_map_box, {at.length, at.width, height + depth});
}

Scene unchanging_part() {
  constexpr double kHalf = 30;
  Scene scene;
  add_ground(scene, kGround, {Eigen::Vector2d(-kHalf, -kHalf), Eigen::Vector2d(kHalf, kHalf)}, 0.5,
             ground_height);
  int object = kGround;
  for (const Footprint& wall : {Footprint{0, -29, 0, 59, 0.4}, Footprint{0, 29, 0, 59, 0.4},
                                Footprint{-29, 0, 0, 0.4, 59}, Footprint{29, 0, 0, 0.4, 59}}) {
    add_standing_box(scene, ++object, wall, 3, 1.5);
  }
  for (const Footprint& container :
       {Footprint{-15, 8, 0.2, 6, 2.4}, Footprint{12, 15, 1.2, 6, 2.4}, Footprint{-17, -18, -0.4, 6, 2.4},
        Footprint{18, -15, 0.8, 12, 2.4}, Footprint{-4, 17, 0.05, 12, 2.4}}) {
    add_standing_box(scene, ++object, container, 2.6);
  }
  for (const Footprint& post :
       {Footprint{0, 8, 0.3, 0.2, 0.2}, Footprint{-10, 3, 0.7, 0.15, 0.15}, Footprint{5, -13, 0.1, 0.3, 0.3},
        Footprint{-14, -5, 0.5, 0.2, 0.2}, Footprint{-2, -13, 0.9, 0.1, 0.1}}) {
    add_standing_box(scene, ++object, post, 3);
  }
  return scene;
}

/// A point of the drive: straight on, a left turn of 90 degrees, straight on.
Pose pose_on_path(double distance) {
  constexpr double kStraight = 7;  ///< [m] before the turn
  constexpr double kRadius = 7;    ///< [m]
  const double yaw = std::clamp((distance - kStraight) / kRadius, 0.0, std::numbers::pi / 2);
  const double after_turn = std::max(0.0, distance - kStraight - kRadius * std::numbers::pi / 2);
  const double x = -11 + std::min(distance, kStraight) + kRadius * std::sin(yaw);
  const double y = -8 + kRadius * (1 - std::cos(yaw)) + after_turn;

  constexpr double kSensorHeight = 1.7;  ///< [m]
  const Eigen::Vector3d up = ground_normal(x, y);
  const Eigen::Vector3d left = up.cross(Eigen::Vector3d(std::cos(yaw), std::sin(yaw), 0)).normalized();
  Pose T_map_sensor;
  T_map_sensor.rotation << left.cross(up), left, up;
  T_map_sensor.translation = {x, y, ground_height(x, y) + kSensorHeight};
  return T_map_sensor;
}

std::vector<Pose> drive() {
  constexpr int kPoses = 60;
  constexpr double kPeriod = 0.1;                      ///< [s] between poses
  constexpr double kPulse = 2 * std::numbers::pi / 6;  ///< [rad/s] of the speed, 3.5 + 1.5 sin(kPulse t) m/s
  std::vector<Pose> T_map_sensor;
  for (int i = 0; i < kPoses; ++i) {
    const double time = i * kPeriod;
    T_map_sensor.push_back(pose_on_path(3.5 * time + 1.5 / kPulse * (1 - std::cos(kPulse * time))));
  }
  return T_map_sensor;
}

}  // namespace

Yard make_yard() {
  Yard yard{unchanging_part(), {}, drive()};
  yard.now = yard.before;

  add_standing_box(yard.before, Yard::kVanished, {-8, -3, 0.3, 2.4, 2}, 2);
  add_standing_box(yard.now, Yard::kAppeared, {8, -6, -0.5, 2.5, 2}, 1.8);

  const Footprint parked{-3, 2, 0.4, 3, 1.8};
  Footprint shifted = parked;
  shifted.x += 0.25 * std::cos(parked.yaw);
  shifted.y += 0.25 * std::sin(parked.yaw);
  // Raised and sunk alike, so that the shift is level although the ground is not.
  const double rise = ground_height(parked.x, parked.y) - ground_height(shifted.x, shifted.y);
  add_standing_box(yard.before, Yard::kMoved, parked, 1.6);
  add_standing_box(yard.now, Yard::kMoved, shifted, 1.6 + rise, 0.4 - rise);

  const Eigen::Vector2d heap_center(9.5, 3.5);
  add_heap(yard.before, Yard::kHeap, {heap_center, 3.0, 1.2}, ground_height);
  add_heap(yard.now, Yard::kHeap, {heap_center, 3.8, 1.8}, ground_height);
  return yard;
}

}  // namespace evermap
