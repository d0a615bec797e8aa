// SPDX-FileCopyrightText: 2026 the evermap authors
// SPDX-License-Identifier: BSD-3-Clause
#include <algorithm>
#include <cmath>
#include <functional>
#include <vector>

#include <gtest/gtest.h>

#include "localization/worlds.hpp"
#include <evermap/geometry/detail/degree.hpp>
#include <evermap/localization/detail/perturbation.hpp>
#include <evermap/maintenance/map_maintainer.hpp>
#include <evermap/maintenance/survey.hpp>
#include <evermap/update/detail/map_updater.hpp>

namespace evermap {
namespace {

constexpr double kPeriod = 0.1;  // [s]

Pose at(double x, double y, double z, double yaw = 0) {
  return {Eigen::AngleAxisd(yaw, Eigen::Vector3d::UnitZ()).toRotationMatrix(), {x, y, z}};
}

/// Four walls, floor and ceiling around [-x, x] x [-y, y], shifted as a whole; a survey shows both faces of
/// each.
Scene room(double x, double y, const Eigen::Vector3d& shift, double thickness = 0.2) {
  constexpr double kHeight = 2.6;
  Scene scene;
  const auto box = [&](int object, const Eigen::Vector3d& center, const Eigen::Vector3d& size) {
    add_box(scene, object, at(center.x() + shift.x(), center.y() + shift.y(), center.z() + shift.z()), size);
  };
  const double out = thickness / 2;
  for (const double side : {-1.0, 1.0}) {
    box(side > 0 ? 1 : 2, {0, side * (y + out), kHeight / 2}, {2 * x + 2 * thickness, thickness, kHeight});
    box(side > 0 ? 3 : 4, {side * (x + out), 0, kHeight / 2}, {thickness, 2 * y, kHeight});
    box(side > 0 ? 5 : 6, {0, 0, kHeight / 2 + side * (kHeight / 2 + out)},
        {2 * x + 2 * thickness, 2 * y + 2 * thickness, thickness});
  }
  box(7, {-0.6 * x, y - 0.2, 0.5}, {1, 0.4, 1});
  box(8, {0.5 * x, -y + 0.2, 0.9}, {0.8, 0.4, 1.8});
  return scene;
}

struct Outcome {
  std::size_t believed = 0;
  std::size_t written = 0;
  double worst = 0;       ///< [m] of what was believed
  double worst_turn = 0;  ///< [rad]
  TrackingState last = TrackingState::kLost;
};

Outcome run(MapMaintainer& maintainer, const Scene& scene, const LidarModel& lidar, std::size_t scans,
            const std::function<Pose(double time)>& truth, const Pose& T_truth_map = {},
            bool has_odometry = false,
            const std::function<std::optional<Eigen::Matrix3d>(double time)>& gyroscope = {}) {
  const Simulator simulator(scene);
  std::vector<ScanResult> all;
  for (std::size_t i = 0; i < scans; ++i) {
    const double time = kPeriod * static_cast<double>(i + 1);
    const Pose T_true = truth(time);
    append(all, maintainer.process(simulator.scan(T_true, lidar, i), time,
                                   has_odometry ? std::optional(T_true) : std::nullopt,
                                   gyroscope ? gyroscope(time) : std::nullopt));
  }
  Outcome result;
  result.last = maintainer.state();
  for (const ScanResult& found : all) {
    result.written += found.is_written;
    if (!found.is_believed()) continue;
    ++result.believed;
    const Twist off = difference(truth(found.time), T_truth_map * found.T_map_sensor);
    result.worst = std::max(result.worst, off.head<3>().norm());
    result.worst_turn = std::max(result.worst_turn, off.tail<3>().norm());
  }
  return result;
}

// The far faces of thin walls are in the survey, too.
TEST(HardWorlds, AYardIsFollowedWithoutOdometry) {
  for (const double edge : {0.2, 0.4}) {
    const auto truth = [&](double time) { return test::yard().T_map_sensor_at(time); };
    MapMaintainer maintainer(test::survey_map(test::yard().survey_scene(), edge), {}, MapMode::kMaintenance,
                             truth(kPeriod));
    const Outcome yard = run(maintainer, test::yard().scene(0), test::small_lidar(), 30, truth);
    EXPECT_GE(yard.believed, 28U) << edge;
    EXPECT_GE(yard.written, 28U) << edge;
    EXPECT_LT(yard.worst, 0.02) << edge;
  }
}

/// The sides and the ends of a vehicle, 4 x 1.8 m and from 0.5 m below the sensor to 0.5 m above, as it goes
/// the robot's way.
Scan trail(const std::function<Pose(double time)>& truth, double seconds) {
  constexpr double kStep = 0.1;  // [m]
  Scan points;
  for (double time = 0; time < seconds; time += 0.5) {
    for (double z = -0.5; z <= 0.5; z += kStep) {
      for (double x = -2; x <= 2; x += kStep)
        for (const double y : {-0.9, 0.9}) points.p_sensor.push_back(truth(time) * Eigen::Vector3d(x, y, z));
      for (double y = -0.9; y <= 0.9; y += kStep)
        for (const double x : {-2.0, 2.0}) points.p_sensor.push_back(truth(time) * Eigen::Vector3d(x, y, z));
    }
  }
  return points;
}

// What passed here when the map was made is in it still, and the robot begins in the middle of that.
TEST(HardWorlds, AStartAmidTheTrailOfAVehicle) {
  for (const double edge : {0.2, 0.4}) {
    const auto truth = [&](double time) { return test::yard().T_map_sensor_at(time); };
    Octree map = test::survey_map(test::yard().survey_scene(), edge);
    add_cloud(map, trail(truth, 6), {}, {}, {});
    for (const MapMode mode : {MapMode::kLocalization, MapMode::kMaintenance}) {
      MapMaintainer maintainer(map, {}, mode, truth(kPeriod));
      const Outcome yard = run(maintainer, test::yard().scene(0), test::small_lidar(), 20, truth);
      EXPECT_GE(yard.believed, 18U) << edge;
      EXPECT_LT(yard.worst, 0.03) << edge;
    }
  }
}

TEST(HardWorlds, ARoomWhoseSurveyShowsBothFacesOfItsWalls) {
  for (const double edge : {0.2, 0.4}) {
    for (const Eigen::Vector3d& shift :
         {Eigen::Vector3d(0, 0, 0), Eigen::Vector3d(0.07, 0.05, 0.03), Eigen::Vector3d(0.11, 0.15, 0.1)}) {
      const Scene scene = room(10, 4, shift);
      const auto truth = [&](double time) {
        return at(-0.5 + 0.5 * time + shift.x(), 0.1 + shift.y(), 1 + shift.z());
      };
      MapMaintainer maintainer(test::survey_map(scene, edge, 0.05), {}, MapMode::kLocalization,
                               truth(kPeriod));
      const Outcome inside = run(maintainer, scene, test::small_lidar(), 10, truth);
      EXPECT_GE(inside.believed, 8U) << edge << " " << shift.transpose();
      EXPECT_LT(inside.worst, 0.02) << edge << " " << shift.transpose();
    }
  }
}

// Both faces of a wall lie in one leaf, those of the wall opposite in two.
TEST(HardWorlds, ACorridorOfThinWallsInLargeLeaves) {
  for (const double y : {0.0, 0.2, 0.4, 0.6}) {
    const Scene scene = room(12, 1.6, {0, y, 0}, 0.15);
    const auto truth = [&](double time) { return at(-8 + 1.5 * time, y, 1); };
    MapMaintainer maintainer(test::survey_map(scene, 0.8, 0.05), {}, MapMode::kLocalization, truth(kPeriod));
    const Outcome inside = run(maintainer, scene, test::small_lidar(), 10, truth, {}, true);
    EXPECT_GE(inside.believed, 9U) << y;
    EXPECT_LT(inside.worst, 0.05) << y;
  }
}

TEST(HardWorlds, ACorridorWhoseEndsAreInSight) {
  for (const double half_width : {0.8, 2.0}) {
    const Scene scene = room(30, half_width, {0, 0, 0});
    const auto truth = [&](double time) { return at(-20 + 1.5 * time, 0, 1); };
    MapMaintainer maintainer(test::survey_map(scene, 0.2, 0.05), {}, MapMode::kLocalization, truth(kPeriod));
    const Outcome inside = run(maintainer, scene, test::small_lidar(), 15, truth, {}, true);
    EXPECT_GE(inside.believed, 14U) << half_width;
    EXPECT_LT(inside.worst, 0.02) << half_width;
  }
}

TEST(HardWorlds, OdometryThatStartsAtSpeed) {
  for (const double speed : {0.0, 4.0, 8.0}) {
    const Scene scene = test::yard().scene(0);
    const auto truth = [&](double time) { return at(-12 + speed * time, -8, 1.7); };
    MapMaintainer maintainer(Octree(VoxelGrid{0.4}), {}, MapMode::kMapping);
    LidarModel lidar = test::small_lidar();
    lidar.channels = 64;
    const Outcome from_nothing = run(maintainer, scene, lidar, 12, truth, truth(kPeriod));
    EXPECT_GE(from_nothing.believed, 10U) << speed;
    EXPECT_LT(from_nothing.worst, 0.05) << speed;
  }
}

// A vehicle that turns into a bend of 4 m at 4.5 m/s turns by 6 degrees more from one scan to the next.
TEST(HardWorlds, ASharpTurnIsNoReasonForAlarm) {
  const Scene scene = test::yard().scene(0);
  const auto truth = [&](double time) {
    return at(-12 + time, -8, 1.7, std::max(0.0, time - 1) * 64 * kDegree);
  };
  MapMaintainer maintainer(test::survey_map(scene, 0.4), {}, MapMode::kLocalization, truth(kPeriod));
  const Outcome turning = run(maintainer, scene, test::small_lidar(), 20, truth);
  EXPECT_GE(turning.believed, 18U);
  EXPECT_LT(turning.worst, 0.02);
  EXPECT_LT(turning.worst_turn, 0.2 * kDegree);
}

// 95 degrees a second from one scan to the next: a robot that turns on the spot.
TEST(HardWorlds, ATurnOnTheSpot) {
  const Scene scene = room(10, 4, {0, 0, 0});
  for (const double rate : {-95.0, 150.0}) {
    const auto truth = [&](double time) { return at(-2, 0.5, 1, std::max(0.0, time - 1) * rate * kDegree); };
    MapMaintainer maintainer(test::survey_map(scene, 0.2, 0.05), {}, MapMode::kMaintenance, truth(kPeriod));
    const Outcome turning = run(maintainer, scene, test::small_lidar(), 20, truth);
    EXPECT_GE(turning.believed, 18U) << rate;
    EXPECT_LT(turning.worst, 0.02) << rate;
    EXPECT_LT(turning.worst_turn, 0.2 * kDegree) << rate;
  }
}

// Nothing holds the robot along an endless corridor but its odometry; the rest is found all the same.
TEST(HardWorlds, AnEndlessCorridorIsFollowedByOdometry) {
  const Scene scene = test::corridor();
  const auto truth = [](double time) { return at(1.5 * time, 0.3, 0.2, 0.05); };
  MapMaintainer maintainer(test::survey_map(scene, 0.4), {}, MapMode::kMaintenance, truth(kPeriod));
  const Outcome inside = run(maintainer, scene, test::small_lidar(), 10, truth, {}, true);
  EXPECT_GE(inside.believed, 9U);
  EXPECT_LT(inside.worst, 0.05);
  EXPECT_EQ(inside.written, 0U) << "where the first scan is along it, nobody knows";
}

// In a map of another place nothing is believed, and nothing is written.
TEST(HardWorlds, AMapOfAnotherPlaceIsFoundOut) {
  MapMaintainer maintainer(test::survey_map(test::yard().survey_scene(), 0.4), {}, MapMode::kMaintenance,
                           at(0, 0, 1.7));
  const Outcome elsewhere = run(maintainer, room(10, 4, {0, 0, 0}), test::small_lidar(), 30,
                                [](double time) { return at(0.5 * time, 0, 1); });
  EXPECT_EQ(elsewhere.believed, 0U);
  EXPECT_EQ(elsewhere.written, 0U);
  EXPECT_EQ(elsewhere.last, TrackingState::kLost);
}

/// Stands for a second, then turns to and fro by a third of a turn in each scan.
double restless_yaw(double time) {
  const int scan = static_cast<int>(std::lround(time / kPeriod)) - 10;
  return scan > 0 && scan % 4 < 2 ? 2 * M_PI / 3 * (scan % 2 == 0 ? 1 : 2) : 0;
}

TEST(Gyroscope, TellsTurnsThatNothingElseWould) {
  const Scene scene = room(6, 4, {0, 0, 0});
  LidarModel lidar;
  lidar.channels = 16;
  lidar.columns = 512;
  constexpr std::size_t kScans = 40;
  const auto truth = [](double time) { return at(0.4, 0.3, 1, restless_yaw(time)); };
  Octree survey(VoxelGrid{0.2});
  add_survey(survey, Simulator(scene).scan(truth(0), LidarModel{}, 99), truth(0));
  const auto drifting = [&](double time) {
    constexpr double kBias = kDegree;  // [rad/s]
    return std::optional<Eigen::Matrix3d>(at(0, 0, 0, kBias * time).rotation * truth(time).rotation);
  };
  MapMaintainer with(survey, {}, MapMode::kLocalization, truth(0));
  const Outcome told = run(with, scene, lidar, kScans, truth, {}, false, drifting);
  EXPECT_EQ(told.believed, kScans);
  EXPECT_LT(told.worst, 0.02);
  MapMaintainer without(survey, {}, MapMode::kLocalization, truth(0));
  const Outcome guessed = run(without, scene, lidar, kScans, truth);
  EXPECT_LT(guessed.believed, kScans * 3 / 4);
  EXPECT_LT(guessed.worst, 0.02);
}

}  // namespace
}  // namespace evermap
