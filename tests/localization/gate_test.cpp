// SPDX-FileCopyrightText: 2026 the evermap authors
// SPDX-License-Identifier: BSD-3-Clause
#include <gtest/gtest.h>

#include <evermap/localization/detail/gate.hpp>

namespace evermap {
namespace {

Registration fitting(double x, double residual = 1, double fraction = 0.9) {
  Registration registration;
  registration.reject_reason = RejectReason::kNone;
  registration.T_map_sensor.translation.x() = x;
  registration.residual = residual;
  registration.matched_fraction = 1;
  registration.inlier_fraction = fraction;
  return registration;
}

class GateTest : public ::testing::Test {
 protected:
  GateTest() {
    for (int i = 0; i < 10; ++i) gate_.remember(fitting(0.01), Pose{}, true);
  }
  bool passes(const Registration& registration, double slack = 1) const {
    return gate_.judge(registration, Pose{}, slack) == RejectReason::kNone;
  }
  Gate gate_{GateParameters{}};
};

TEST_F(GateTest, ObjectsToWhatDidNotConverge) {
  Registration registration = fitting(0);
  EXPECT_TRUE(passes(registration));
  registration.reject_reason = RejectReason::kUnobservable;
  EXPECT_EQ(gate_.judge(registration, Pose{}, 1), RejectReason::kUnobservable);
}

TEST_F(GateTest, ObjectsToAPoseFarFromThePrediction) {
  EXPECT_TRUE(passes(fitting(0.29)));
  EXPECT_FALSE(passes(fitting(0.31)));
  EXPECT_TRUE(passes(fitting(0.31), 2));
  Registration turned = fitting(0);
  turned.T_map_sensor.rotation = Eigen::AngleAxisd(0.052, Eigen::Vector3d::UnitY()).toRotationMatrix();
  EXPECT_TRUE(passes(turned));
  turned.T_map_sensor.rotation = Eigen::AngleAxisd(0.053, Eigen::Vector3d::UnitY()).toRotationMatrix();
  EXPECT_FALSE(passes(turned));
}

TEST_F(GateTest, ObjectsToAWorseFitThanBefore) {
  EXPECT_TRUE(passes(fitting(0, 2.9)));
  EXPECT_FALSE(passes(fitting(0, 3.1)));
  EXPECT_TRUE(passes(fitting(0, 1, 0.69)));
  EXPECT_FALSE(passes(fitting(0, 1, 0.66)));
}

TEST(Gate, WidensForARobotThatMovesRoughlyButNotWithoutLimit) {
  Gate gate{GateParameters{}};
  for (int i = 0; i < 10; ++i) gate.remember(fitting(0.15), Pose{}, true);
  EXPECT_EQ(gate.judge(fitting(0.44), Pose{}, 1), RejectReason::kNone);
  EXPECT_EQ(gate.judge(fitting(0.46), Pose{}, 1), RejectReason::kTooFar);
  for (int i = 0; i < 60; ++i) gate.remember(fitting(5), Pose{}, true);
  EXPECT_EQ(gate.judge(fitting(0.61), Pose{}, 1), RejectReason::kTooFar);
}

Registration scoring(double score) {
  Registration registration = fitting(0.01, 1, 1);
  registration.fit = score;
  return registration;
}

TEST(Gate, AScoreThatFallsAtOnceIsUnusual) {
  Gate steady{GateParameters{}};
  Gate noisy{GateParameters{}};
  for (int i = 0; i < 20; ++i) {
    steady.remember(scoring(0.9), Pose{}, true);
    noisy.remember(scoring(i % 2 == 0 ? 0.87 : 0.9), Pose{}, true);
  }
  EXPECT_TRUE(steady.is_usual(scoring(0.89)));
  EXPECT_FALSE(steady.is_usual(scoring(0.87)));
  EXPECT_TRUE(noisy.is_usual(scoring(0.87)));
  EXPECT_FALSE(noisy.is_usual(scoring(0.75)));
  for (int i = 0; i < 10; ++i) steady.remember(scoring(0.9 - 0.015 * i), Pose{}, true);
  EXPECT_TRUE(steady.is_usual(scoring(0.75))) << "it fell little by little";
}

}  // namespace
}  // namespace evermap
