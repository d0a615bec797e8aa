// SPDX-FileCopyrightText: 2026 the evermap authors
// SPDX-License-Identifier: BSD-3-Clause
#include <gtest/gtest.h>

#include <evermap/geometry/detail/trajectory.hpp>

namespace evermap {
namespace {

Pose at_x(double x) { return {Eigen::Matrix3d::Identity(), {x, 0, 0}}; }

TEST(Trajectory, GoesSteadilyFromPoseToPose) {
  Trajectory trajectory;
  EXPECT_FALSE(trajectory.at(1));
  for (const double time : {1.0, 2.0, 3.0}) trajectory.add(time, at_x(time * time));
  EXPECT_NEAR(trajectory.at(1.5).value().translation.x(), 2.5, 1e-12);
  EXPECT_NEAR(trajectory.at(2.25).value().translation.x(), 5.25, 1e-12);
  EXPECT_EQ(trajectory.at(2 + 1e-7).value().translation.x(), 4);  // as times are rounded
  EXPECT_EQ(trajectory.at(3 + 1e-7).value().translation.x(), 9);
  EXPECT_FALSE(trajectory.at(0.99));
  EXPECT_FALSE(trajectory.at(3.01));
}

TEST(Trajectory, LeavesOutWhatIsNotLater) {
  Trajectory trajectory;
  trajectory.add(1, at_x(1));
  trajectory.add(1, at_x(7));
  trajectory.add(0.5, at_x(7));
  trajectory.add(2, at_x(2));
  EXPECT_NEAR(trajectory.at(1.5).value().translation.x(), 1.5, 1e-12);
}

TEST(Trajectory, ForgetsAllButThePoseBefore) {
  Trajectory trajectory;
  for (const double time : {1.0, 2.0, 3.0, 4.0}) trajectory.add(time, at_x(time));
  trajectory.forget_before(2.5);
  EXPECT_FALSE(trajectory.at(1.5));
  EXPECT_NEAR(trajectory.at(2.5).value().translation.x(), 2.5, 1e-12);
}

}  // namespace
}  // namespace evermap
