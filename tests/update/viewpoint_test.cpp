// SPDX-FileCopyrightText: 2026 the evermap authors
// SPDX-License-Identifier: BSD-3-Clause
#include <gtest/gtest.h>

#include <evermap/update/detail/viewpoint.hpp>

namespace evermap {
namespace {

Pose at(double x, double yaw = 0) {
  return {Eigen::AngleAxisd(yaw, Eigen::Vector3d::UnitZ()).toRotationMatrix(), {x, 0, 0}};
}

TEST(Viewpoint, RepeatedLooksAddLessAndLess) {
  Viewpoint viewpoint(0.1);
  for (int k = 1; k <= 5; ++k) EXPECT_DOUBLE_EQ(viewpoint.view_weight(at(7.01)), 1.0 / k);
}

TEST(Viewpoint, AMoveOrATurnIsANewLook) {
  Viewpoint viewpoint(0.1);
  EXPECT_EQ(viewpoint.view_weight(at(0)), 1);
  EXPECT_EQ(viewpoint.view_weight(at(0.11)), 1);
  EXPECT_EQ(viewpoint.view_weight(at(0.11, 0.02)), 1);
  EXPECT_EQ(viewpoint.view_weight(at(0.11, 0.03)), 0.5);
}

TEST(Viewpoint, CreepingIsMeasuredFromTheFirstLook) {
  Viewpoint viewpoint(0.1);
  EXPECT_EQ(viewpoint.view_weight(at(0)), 1);
  EXPECT_EQ(viewpoint.view_weight(at(0.06)), 0.5);
  EXPECT_EQ(viewpoint.view_weight(at(0.12)), 1);
}

TEST(Viewpoint, NoRadiusMakesEveryLookNew) {
  Viewpoint viewpoint(0);
  EXPECT_EQ(viewpoint.view_weight(at(0)), 1);
  EXPECT_EQ(viewpoint.view_weight(at(0)), 1);
}

}  // namespace
}  // namespace evermap
