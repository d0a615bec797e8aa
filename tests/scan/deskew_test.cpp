// SPDX-FileCopyrightText: 2026 the evermap authors
// SPDX-License-Identifier: BSD-3-Clause
#include <gtest/gtest.h>

#include "support/random_geometry.hpp"
#include <evermap/scan/detail/deskew.hpp>

namespace evermap {
namespace {

TEST(Deskew, BringsAllPointsToTheScansEnd) {
  test::Random random(1);
  constexpr double kDuration = 0.1;
  const Twist motion = (Twist() << 0.8, 0.1, -0.02, 0.01, -0.03, 0.1).finished();
  Scan raw;
  std::vector<Eigen::Vector3d> truth;  // in the sensor's frame at the end
  for (int i = 0; i < 500; ++i) {
    const double moment = kDuration * i / 500;
    truth.push_back(random.in_cube(30));
    // The world as the sensor saw it at that moment: T_begin_then^-1 T_begin_end p_end.
    const Pose T_then_end = exp(motion * (moment / kDuration)).inverse() * exp(motion);
    raw.p_sensor.push_back(T_then_end * truth.back());
    raw.time_offset.push_back(static_cast<float>(moment));
  }
  const Scan still = deskew(raw, ScanMotion::steady(motion / kDuration), kDuration);
  for (std::size_t i = 0; i < truth.size(); ++i) EXPECT_LT((still.p_sensor[i] - truth[i]).norm(), 1e-5);
  EXPECT_TRUE(still.time_offset.empty());
}

TEST(Deskew, KnowsThatASensorChangedItsVelocity) {
  test::Random random(2);
  constexpr double kDuration = 0.1;
  const ScanMotion motion{Twist::UnitX() * 5, Twist::UnitX() * 5 + Twist::Unit(5), 0.4};
  Scan raw;
  std::vector<Eigen::Vector3d> truth;
  for (int i = 0; i < 500; ++i) {
    const double moment = kDuration * i / 500;
    truth.push_back(random.in_cube(30));
    const Pose T_begin_bend = exp(motion.before * kDuration * motion.bend);
    const Pose T_begin_end = T_begin_bend * exp(motion.after * kDuration * (1 - motion.bend));
    const double since_bend = moment - kDuration * motion.bend;
    const Pose T_begin_then =
        since_bend < 0 ? exp(motion.before * moment) : T_begin_bend * exp(motion.after * since_bend);
    raw.p_sensor.push_back(T_begin_then.inverse() * T_begin_end * truth.back());
    raw.time_offset.push_back(static_cast<float>(moment));
  }
  const Scan still = deskew(raw, motion, kDuration);
  for (std::size_t i = 0; i < truth.size(); ++i) EXPECT_LT((still.p_sensor[i] - truth[i]).norm(), 1e-5);
}

TEST(Deskew, TimesThatAreAllTheSameAreNone) {
  Scan scan;
  EXPECT_FALSE(has_times(scan));
  scan.time_offset = {0, 0, 0};
  EXPECT_FALSE(has_times(scan));
  scan.time_offset = {0, 0, 0.01F};
  EXPECT_TRUE(has_times(scan));
}

TEST(Deskew, LeavesAScanWithoutTimesAsItIs) {
  const ScanMotion motion = ScanMotion::steady(Twist::UnitX());
  Scan scan;
  scan.p_sensor = {{1, 2, 3}, {4, 5, 6}};
  EXPECT_EQ(deskew(scan, motion, 0.1).p_sensor, scan.p_sensor);
  scan.time_offset = {0, 0};
  EXPECT_EQ(deskew(scan, motion, 0.1).p_sensor, scan.p_sensor);
}

}  // namespace
}  // namespace evermap
