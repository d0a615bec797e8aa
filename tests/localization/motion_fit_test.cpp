// SPDX-FileCopyrightText: 2026 the evermap authors
// SPDX-License-Identifier: BSD-3-Clause
#include <cstddef>
#include <optional>

#include <gtest/gtest.h>

#include "localization/worlds.hpp"
#include "support/random_geometry.hpp"
#include <evermap/localization/detail/motion_fit.hpp>
#include <evermap/localization/detail/perturbation.hpp>

namespace evermap {
namespace {

using test::kPeriod;

Twist forward(double speed, double turn) {
  Twist velocity = Twist::Zero();
  velocity[0] = speed;
  velocity[5] = turn;
  return velocity;
}

/// A place in the yard where a scan ended.
class MotionFit : public ::testing::Test {
 protected:
  /// The scan as a sensor saw it that moved like this.
  Scan raw(const ScanMotion& motion) const {
    Scan raw = scan_;
    const std::size_t count = raw.p_sensor.size();
    for (std::size_t i = 0; i < count; ++i) {
      const double fraction = static_cast<double>(i) / static_cast<double>(count);
      raw.p_sensor[i] = motion.pose_at(fraction, kPeriod).inverse() * scan_.p_sensor[i];
      raw.time_offset.push_back(static_cast<float>(fraction * kPeriod));
    }
    return raw;
  }
  Pose begin(const ScanMotion& motion) const { return T_map_sensor_ * motion.pose_at(0, kPeriod); }
  double turned_off(const Pose& found) const {
    return difference(T_map_sensor_, found).tail<3>().norm() / kDegree;
  }
  double moved_off(const Pose& found) const { return difference(T_map_sensor_, found).head<3>().norm(); }

  /// Fits, from the motion that the scan began with, as often as it gains.
  MovingPose fitted(const ScanMotion& motion, const std::optional<Pose>& by_odometry = std::nullopt) const {
    const Scan scan = raw(motion);
    const ScanMotion steady = ScanMotion::steady(motion.before);
    MovingPose found{steady, begin(motion) * steady.pose_at(0, kPeriod).inverse()};
    MotionPrior prior{{begin(motion), within(0.01, 0.001)}, within(0.05, kDegree), std::nullopt};
    if (by_odometry) prior.end = {*by_odometry, within(0.01, 0.1 * kDegree)};
    for (int i = 0; i < 4; ++i) {
      const Scan still = deskew(scan, found.motion, kPeriod);
      const auto better = fit_motion(map_, scan, still, found, prior, lidar_, parameters_);
      if (better.empty()) break;
      found = better.back();
    }
    return found;
  }

  const Octree map_ = test::survey_map(test::yard().scene(0), 0.4);
  const Pose T_map_sensor_ = test::yard().T_map_sensor(20);
  const Scan scan_ = Simulator(test::yard().scene(0)).scan(T_map_sensor_, test::small_lidar(), 1);
  const LidarParameters lidar_{};
  const RegistrationParameters parameters_{};
};

TEST_F(MotionFit, FindsWhereAScanEndsThatTurned) {
  test::Random random(3);
  for (int i = 0; i < 10; ++i) {
    const double turn = (random.chance(0.5) ? 1 : -1) * random.uniform(20, 50) * kDegree;
    const ScanMotion motion{forward(5, 0), forward(5, turn), random.uniform(0.1, 0.6)};
    const MovingPose found = fitted(motion);
    EXPECT_LT(turned_off(found.T_map_sensor), 0.35) << "bend " << motion.bend << ", turn " << turn / kDegree;
    EXPECT_LT(moved_off(found.T_map_sensor), 0.05);
    const Pose steady = begin(motion) * exp(motion.before * kPeriod);
    EXPECT_LT(turned_off(found.T_map_sensor), 0.3 * turned_off(steady));
  }
}

TEST_F(MotionFit, LeavesASteadyMotionAlone) {
  for (const double turn : {-40, 0, 40}) {
    const ScanMotion motion = ScanMotion::steady(forward(8, turn * kDegree));
    const MovingPose found = fitted(motion);
    EXPECT_EQ(found.motion.bend, 0);
    EXPECT_EQ(found.motion.after, motion.after);
  }
}

// A sixteenth of a scan hardly tells; odometry does.
TEST_F(MotionFit, OdometryTellsATurnAtTheVeryEnd) {
  for (const double turn : {-120, 120}) {
    const ScanMotion motion{forward(3, 0), forward(3, turn * kDegree), 15.0 / 16};
    EXPECT_LT(turned_off(fitted(motion, T_map_sensor_).T_map_sensor), 0.3) << turn;
  }
}

/// A guess: where little of the scan was taken after the turn began, little tells it.
TEST_F(MotionFit, GuessesMostSharpTurns) {
  test::Random random(5);
  int near = 0;
  for (int i = 0; i < 20; ++i) {
    const double turn = random.uniform(-130, 130) * kDegree;
    const ScanMotion motion{forward(3, 0), forward(3, turn), random.uniform(0, 0.8)};
    const MovingPose guess = best_turn(map_, raw(motion), begin(motion), motion.before, lidar_, parameters_);
    near += turned_off(guess.T_map_sensor) < 2 ? 1 : 0;
  }
  EXPECT_GE(near, 13);
}

TEST_F(MotionFit, GuessesTheEndOfATurn) {
  const ScanMotion motion{forward(3, 100 * kDegree), forward(3, 0), 0.5};
  const MovingPose guess = best_turn(map_, raw(motion), begin(motion), motion.before, lidar_, parameters_);
  EXPECT_LT(turned_off(guess.T_map_sensor), 2);
}

}  // namespace
}  // namespace evermap
