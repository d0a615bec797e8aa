// SPDX-FileCopyrightText: 2026 the evermap authors
// SPDX-License-Identifier: BSD-3-Clause
#include <cmath>
#include <support/random_geometry.hpp>

#include <gtest/gtest.h>
#include <rapidcheck/gtest.h>

#include <evermap/evaluation/trajectory_metrics.hpp>

namespace evermap {
namespace {

using test::Random;

Pose random_pose(Random& random, double metres, double radians) {
  Twist twist;
  for (int i = 0; i < 3; ++i) twist[i] = random.uniform(-metres, metres);
  for (int i = 3; i < 6; ++i) twist[i] = random.uniform(-radians, radians);
  return exp(twist);
}

std::vector<Pose> random_trajectory(Random& random, std::size_t size) {
  std::vector<Pose> poses;
  for (std::size_t i = 0; i < size; ++i) poses.push_back(random_pose(random, 20, 1));
  return poses;
}

std::vector<Pose> disturbed(const std::vector<Pose>& poses, Random& random, double metres, double radians) {
  std::vector<Pose> result;
  for (const Pose& pose : poses) result.push_back(pose * random_pose(random, metres, radians));
  return result;
}

std::vector<Pose> moved(const Pose& T_other_map, const std::vector<Pose>& poses) {
  std::vector<Pose> result;
  for (const Pose& pose : poses) result.push_back(T_other_map * pose);
  return result;
}

double squared_distance(const Pose& motion, const std::vector<Pose>& truth, const std::vector<Pose>& poses) {
  double sum = 0;
  for (std::size_t i = 0; i < poses.size(); ++i) {
    sum += (motion * poses[i].translation - truth[i].translation).squaredNorm();
  }
  return sum;
}

/// The least distance that any rigid motion reaches, by descent from the identity along random twists.
double aligned_rmse_by_search(const std::vector<Pose>& truth, const std::vector<Pose>& poses,
                              Random& random) {
  Pose motion;
  double best = squared_distance(motion, truth, poses);
  for (double step = 1; step > 1e-9;) {
    bool has_improved = false;
    for (int trial = 0; trial < 100; ++trial) {
      const Pose candidate = random_pose(random, step, step / 20) * motion;
      const double distance = squared_distance(candidate, truth, poses);
      if (distance >= best) continue;
      best = distance;
      motion = candidate;
      has_improved = true;
    }
    if (!has_improved) step *= 0.5;
  }
  return std::sqrt(best / static_cast<double>(poses.size()));
}

RC_GTEST_PROP(TrajectoryMetrics, AgreeWithTheDefinitions, (unsigned seed)) {
  Random random(seed);
  const auto truth = random_trajectory(random, 40);
  const auto poses = disturbed(truth, random, 1.0, 0.08);
  double squared = 0;
  double farthest = 0;
  double squared_angle = 0;
  double widest = 0;
  int lost = 0;
  for (std::size_t i = 0; i < poses.size(); ++i) {
    const double distance = (poses[i].translation - truth[i].translation).norm();
    const double angle = log(truth[i].inverse() * poses[i]).tail<3>().norm();
    squared += distance * distance;
    farthest = std::max(farthest, distance);
    squared_angle += angle * angle;
    widest = std::max(widest, angle);
    lost += distance > 1 || angle > 5 * M_PI / 180 ? 1 : 0;
  }
  const TrajectoryError error = compare_trajectories(truth, poses);
  RC_ASSERT(std::abs(error.translation_rmse() - std::sqrt(squared / 40)) < 1e-12);
  RC_ASSERT(std::abs(error.translation_max() - farthest) < 1e-12);
  RC_ASSERT(std::abs(error.rotation_rmse() - std::sqrt(squared_angle / 40)) < 1e-9);
  RC_ASSERT(std::abs(error.rotation_max() - widest) < 1e-9);
  RC_ASSERT(std::abs(error.fraction_lost() - lost / 40.0) < 1e-12);
  RC_ASSERT(error.aligned_translation_rmse <= error.translation_rmse() + 1e-12);
}

TEST(TrajectoryMetrics, AlignmentIsTheBestRigidMotion) {
  Random random(3);
  for (int trial = 0; trial < 3; ++trial) {
    const auto truth = random_trajectory(random, 15);
    const auto poses = moved(random_pose(random, 1, 0.1), disturbed(truth, random, 0.5, 0.1));
    const double found = aligned_rmse_by_search(truth, poses, random);
    EXPECT_NEAR(compare_trajectories(truth, poses).aligned_translation_rmse, found, 1e-4);
    EXPECT_LE(compare_trajectories(truth, poses).aligned_translation_rmse, found + 1e-9);
  }
}

TEST(TrajectoryMetrics, AShiftedMapShowsWithoutAlignmentOnly) {
  Random random(1);
  const auto truth = random_trajectory(random, 30);
  Pose shift;
  shift.translation = {0.3, -0.4, 0};
  const TrajectoryError error = compare_trajectories(truth, moved(shift, truth));
  EXPECT_NEAR(error.translation_rmse(), 0.5, 1e-12);
  EXPECT_NEAR(error.translation_max(), 0.5, 1e-12);
  EXPECT_NEAR(error.aligned_translation_rmse, 0, 1e-9);
  EXPECT_NEAR(error.rotation_rmse(), 0, 1e-9);
  EXPECT_EQ(error.fraction_lost(), 0);
}

// With scale, the alignment would fit half the size exactly.
TEST(TrajectoryMetrics, AlignmentDoesNotScale) {
  Random random(1);
  const auto truth = random_trajectory(random, 30);
  auto poses = truth;
  for (Pose& pose : poses) pose.translation /= 2;
  EXPECT_GT(compare_trajectories(truth, poses).aligned_translation_rmse, 1);
}

TEST(TrajectoryMetrics, SmallAnglesAreNotRoundedAway) {
  Twist twist = Twist::Zero();
  twist[5] = 1e-10;
  EXPECT_NEAR(compare_trajectories({Pose{}}, {exp(twist)}).rotation_max(), 1e-10, 1e-14);
}

TEST(TrajectoryMetrics, LostIsMoreThanOneMetreOrFiveDegreesOff) {
  const auto pose = [](double metres, double degrees) {
    Twist twist = Twist::Zero();
    twist[5] = degrees * M_PI / 180;
    Pose result = exp(twist);
    result.translation = {metres, 0, 0};
    return result;
  };
  const std::vector<Pose> truth(4);
  const std::vector<Pose> poses{pose(1, 0), pose(1.01, 0), pose(0, 4.99), pose(0, 5.01)};
  EXPECT_EQ(compare_trajectories(truth, poses).fraction_lost(), 0.5);
}

TEST(TrajectoryMetrics, WithoutPosesThereIsNothingToSay) {
  const TrajectoryError error = compare_trajectories({}, {});
  EXPECT_TRUE(std::isnan(error.translation_rmse()));
  EXPECT_TRUE(std::isnan(error.translation_max()));
  EXPECT_TRUE(std::isnan(error.aligned_translation_rmse));
  EXPECT_TRUE(std::isnan(error.rotation_rmse()));
  EXPECT_TRUE(std::isnan(error.fraction_lost()));
}

/// A straight drive of one pose a metre; the found one is a little longer with every step.
std::vector<Pose> straight(std::size_t poses, double step) {
  std::vector<Pose> drive(poses);
  for (std::size_t i = 0; i < poses; ++i) drive[i].translation.x() = step * static_cast<double>(i);
  return drive;
}

TEST(Drift, IsTheErrorPerDistance) {
  const auto truth = straight(201, 1);
  const auto found = straight(201, 1.01);
  EXPECT_EQ(path_length(truth), 200);
  EXPECT_EQ(path_length({}), 0);
  for (const double stretch : {1.0, 50.0, 200.0}) EXPECT_NEAR(drift(truth, found, stretch), 0.01, 1e-9);
  EXPECT_TRUE(std::isnan(drift(truth, found, 201)));
  EXPECT_TRUE(std::isnan(drift({}, {}, 1)));
  Pose shift;
  shift.translation = {3, 4, 5};
  EXPECT_NEAR(drift(truth, moved(shift, truth), 50), 0, 1e-12) << "where a drive begins is no drift";
}

TEST(Drift, IsThatOfEveryPairOfPoses) {
  Random random(5);
  const auto truth = random_trajectory(random, 60);
  const auto found = disturbed(truth, random, 0.3, 0.05);
  const double stretch = 100;
  double sum = 0;
  int count = 0;
  for (std::size_t i = 0; i < truth.size(); ++i) {
    double along = 0;
    for (std::size_t k = i + 1; k < truth.size(); ++k) {
      along += (truth[k].translation - truth[k - 1].translation).norm();
      if (along < stretch) continue;
      const Eigen::Vector3d end_true = truth[i].inverse() * truth[k].translation;
      const Eigen::Vector3d end_found = found[i].inverse() * found[k].translation;
      sum += (end_found - end_true).norm() / stretch;
      ++count;
      break;
    }
  }
  EXPECT_NEAR(drift(truth, found, stretch), sum / count, 1e-12);
}

TEST(MatchTimes, PairsWhatIsEachOthersNearest) {
  const auto pairs = match_times({0.0, 0.101, 0.11, 0.2, 0.35}, {0.1, 0.199, 0.3, 0.4}, 0.02);
  ASSERT_EQ(pairs.size(), 2U);
  EXPECT_EQ(pairs[0].found, 1U);
  EXPECT_EQ(pairs[0].truth, 0U);
  EXPECT_EQ(pairs[1].found, 3U);
  EXPECT_EQ(pairs[1].truth, 1U);
  EXPECT_TRUE(match_times({}, {1}, 1).empty());
  EXPECT_TRUE(match_times({1}, {}, 1).empty());
}

}  // namespace
}  // namespace evermap
