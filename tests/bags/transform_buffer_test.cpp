// SPDX-FileCopyrightText: 2026 the evermap authors
// SPDX-License-Identifier: BSD-3-Clause
#include <Eigen/Geometry>
#include <gtest/gtest.h>

#include <evermap/bags/detail/transform_buffer.hpp>

namespace evermap {
namespace {

StampedTransform at(double time, const std::string& parent, const std::string& child, double x) {
  return {time, parent, child, {Eigen::Matrix3d::Identity(), {x, 0, 0}}};
}

TEST(TransformBuffer, WalksUpAndDownTheTree) {
  TransformBuffer buffer;
  buffer.add(at(0, "map", "odom", 100), true);
  buffer.add(at(0, "odom", "base", 10), true);
  buffer.add(at(0, "base", "lidar", 1), true);
  buffer.add(at(0, "base", "camera", 2), true);
  EXPECT_NEAR(buffer.lookup("map", "lidar", 5).value().translation.x(), 111, 1e-12);
  EXPECT_NEAR(buffer.lookup("lidar", "map", 5).value().translation.x(), -111, 1e-12);
  EXPECT_NEAR(buffer.lookup("camera", "lidar", 5).value().translation.x(), -1, 1e-12);
  EXPECT_NEAR(buffer.lookup("lidar", "lidar", 5).value().translation.x(), 0, 1e-12);
  EXPECT_FALSE(buffer.lookup("earth", "lidar", 5));
  EXPECT_TRUE(buffer.connects("camera", "odom"));
  EXPECT_FALSE(buffer.connects("earth", "odom"));
}

TEST(TransformBuffer, InterpolatesBetweenMomentsAndKnowsNothingBeyond) {
  TransformBuffer buffer;
  buffer.add(at(1, "odom", "base", 0), false);
  buffer.add(at(2, "odom", "base", 8), false);
  buffer.add(at(1.5, "odom", "base", 77), false);  // came too late
  buffer.add(at(9, "odom", "base", 9), false);
  EXPECT_NEAR(buffer.lookup("odom", "base", 1.25).value().translation.x(), 2, 1e-12);
  EXPECT_NEAR(buffer.lookup("odom", "base", 2).value().translation.x(), 8, 1e-12);
  EXPECT_FALSE(buffer.lookup("odom", "base", 0.9));
  EXPECT_FALSE(buffer.lookup("odom", "base", 5));  // in a gap of 7 s it may have been anywhere
  EXPECT_FALSE(buffer.lookup("odom", "base", 9.1));
}

TEST(TransformBuffer, TurnsOnTheShorterWay) {
  const auto turned = [](double time, double degrees) {
    return StampedTransform{
        time,
        "odom",
        "base",
        {Eigen::AngleAxisd(degrees * M_PI / 180, Eigen::Vector3d::UnitZ()).toRotationMatrix(), {0, 0, 0}}};
  };
  TransformBuffer buffer;
  buffer.add(turned(1, 170), false);
  buffer.add(turned(2, -170), false);
  const Eigen::Matrix3d expected = turned(0, 180).T_parent_child.rotation;
  EXPECT_TRUE(buffer.lookup("odom", "base", 1.5).value().rotation.isApprox(expected, 1e-9));
}

TEST(TransformBuffer, ALoopOfFramesEnds) {
  TransformBuffer buffer;
  buffer.add(at(0, "a", "b", 1), true);
  buffer.add(at(0, "b", "c", 1), true);
  buffer.add(at(0, "c", "a", 1), true);
  buffer.add(at(0, "d", "d", 1), true);
  EXPECT_FALSE(buffer.lookup("d", "a", 0));
  EXPECT_FALSE(buffer.connects("d", "a"));
}

}  // namespace
}  // namespace evermap
