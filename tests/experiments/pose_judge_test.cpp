// SPDX-FileCopyrightText: 2026 the evermap authors
// SPDX-License-Identifier: BSD-3-Clause
#include "experiments/pose_judge.hpp"

#include <gtest/gtest.h>

#include <evermap/simulation/scenario_drive.hpp>

namespace evermap {
namespace {

const std::string kOpenPlain =
    "scans: 1\n"
    "lidar: {channels: 32, columns: 256}\n"
    "ground: {area: [-40, -40, 40, 40], features: [{slope: [0, 0]}]}\n"
    "robot: {sensor_height: 1.5, at: [0, 0]}\n"
    "objects:\n";
const std::string kLongWall =
    "  - {name: wall, wall: {from: [-40, 4], to: [40, 4], height: 3, thickness: 0.3}}\n";
const std::string kCrossWall =
    "  - {name: end, wall: {from: [9, -9], to: [9, 9], height: 3, thickness: 0.3}}\n";

/// A judge of the only scan, and the true pose.
struct Judged {
  explicit Judged(const std::string& objects)
      : drive(parse_scenario("test", kOpenPlain + (objects.empty() ? "  []\n" : objects))),
        T_map_sensor(drive.T_map_sensor(0)),
        judge(RayCaster(drive.scene(0)), drive.scan(0).scan.p_sensor, T_map_sensor) {}

  PoseJudge::Error shifted(double x, double y, double z) const {
    Pose off = T_map_sensor;
    off.translation += Eigen::Vector3d(x, y, z);
    return judge.error(off);
  }

  ScenarioDrive drive;
  Pose T_map_sensor;
  PoseJudge judge;
};

TEST(PoseJudge, APlainTellsHeightAlone) {
  const Judged plain("");
  EXPECT_FALSE(plain.judge.is_observable());
  EXPECT_NEAR(plain.shifted(0.3, 0.4, 0).translation, 0, 0.01);
  EXPECT_NEAR(plain.shifted(0, 0, 0.2).translation, 0.2, 0.01);
}

TEST(PoseJudge, AWallTellsNothingAlongItself) {
  const Judged wall(kLongWall);
  EXPECT_FALSE(wall.judge.is_observable());
  EXPECT_NEAR(wall.shifted(0.3, 0, 0).translation, 0, 0.02);
  EXPECT_NEAR(wall.shifted(0, 0.3, 0).translation, 0.3, 0.02);
}

TEST(PoseJudge, TwoWallsAndTheGroundTellAll) {
  const Judged corner(kLongWall + kCrossWall);
  EXPECT_TRUE(corner.judge.is_observable());
  EXPECT_NEAR(corner.shifted(0.3, 0.4, 0).translation, 0.5, 1e-9);
  EXPECT_EQ(corner.shifted(0, 0, 0).rotation, 0);
}

}  // namespace
}  // namespace evermap
