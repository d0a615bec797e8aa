// SPDX-FileCopyrightText: 2026 the evermap authors
// SPDX-License-Identifier: BSD-3-Clause
#include <gtest/gtest.h>

#include "localization/worlds.hpp"
#include <evermap/localization/localizer.hpp>
#include <evermap/localization/perturbation.hpp>

namespace evermap {
namespace {

constexpr double kPeriod = 0.1;  // [s]
constexpr std::size_t kScans = 40;

/// A drive through the yard, with the map maintained where the localizer lets it.
class Drive {
 public:
  Drive() {
    const Simulator simulator(yard_.before);
    for (std::size_t i = 0; i < kScans; ++i) {
      scans_.push_back(simulator.scan(yard_.T_map_sensor[i], test::small_lidar(), i));
    }
  }
  const Pose& truth(std::size_t i) const { return yard_.T_map_sensor[i]; }
  const Octree& survey() const { return survey_; }
  const Scan& scan(std::size_t i) const { return scans_[i]; }

 private:
  Yard yard_ = make_yard();
  Octree survey_ = test::survey_map(yard_.before, 0.4);
  std::vector<Scan> scans_;
};
const Drive& drive() {
  static const Drive the_drive;
  return the_drive;
}

/// Share of the survey's wall that the map has no longer. Nothing else reaches so far out and up.
double share_of_walls_lost(const Octree& map) {
  double walls = 0;
  double lost = 0;
  drive().survey().for_each_leaf([&](VoxelKey key, const Leaf& leaf) {
    const Eigen::Vector3d p = map.grid().center(key);
    if (!leaf.occupied() || p.head<2>().cwiseAbs().maxCoeff() < 28 || p.z() < 1) return;
    const Leaf* now = map.find(key);
    walls += 1;
    lost += now == nullptr || !now->occupied();
  });
  return lost / walls;
}

struct Outcome {
  Octree map{VoxelGrid{}};
  double worst_written = 0;  ///< [m] error of a pose that was written into the map
  std::size_t written = 0;
  TrackingState last = TrackingState::kLost;
  std::size_t not_tracking = 0;
};

/// Drives with an odometry that is off by `error` in scans [begin, end).
Outcome drive_with(const Twist& error, std::size_t begin, std::size_t end, const Twist& initial_error) {
  Outcome outcome;
  outcome.map = drive().survey();
  Localizer localizer(perturb(drive().truth(0), initial_error), {});
  for (std::size_t i = 0; i < kScans; ++i) {
    const bool is_wrong = i >= begin && i < end;
    const Pose T_odom_sensor = is_wrong ? perturb(drive().truth(i), error) : drive().truth(i);
    const Localization at =
        localizer.localize(outcome.map, drive().scan(i), kPeriod * static_cast<double>(i), T_odom_sensor);
    outcome.last = at.state;
    outcome.not_tracking += !localizer.may_update();
    if (!localizer.may_update()) continue;
    update(outcome.map, drive().scan(i), at.T_map_sensor, UpdateParameters{});
    ++outcome.written;
    const Twist off = difference(drive().truth(i), at.T_map_sensor);
    outcome.worst_written = std::max(outcome.worst_written, off.head<3>().norm());
  }
  return outcome;
}

TEST(Localizer, TracksADriveWithoutOdometry) {
  const Octree& map = drive().survey();
  Localizer localizer(drive().truth(0), {});
  std::size_t tracked = 0;
  for (std::size_t i = 0; i < kScans; ++i) {
    const Localization at =
        localizer.localize(map, drive().scan(i), kPeriod * static_cast<double>(i), std::nullopt);
    EXPECT_LT((at.T_map_sensor.translation - drive().truth(i).translation).norm(), 0.01);
    tracked += localizer.may_update();
    EXPECT_FALSE(i < 2 && localizer.may_update());
  }
  // Where the drive's bends begin and end, it turns by more than 2 degrees other than it did.
  EXPECT_GE(tracked, kScans - 2 - 8);
}

struct Poison {
  double translation;  ///< [m]
  double degrees;
  std::size_t scans;
};
class PoisonTest : public ::testing::TestWithParam<Poison> {};

TEST_P(PoisonTest, NeverDamagesTheMap) {
  const Poison& poison = GetParam();
  Twist error = Twist::Zero();
  error.x() = poison.translation;
  error[5] = poison.degrees * 0.017453292519943295;
  const Outcome outcome = drive_with(error, 10, 10 + poison.scans, Twist::Zero());
  EXPECT_LT(outcome.worst_written, 0.02);
  EXPECT_LE(share_of_walls_lost(outcome.map), 0.01);
  EXPECT_EQ(outcome.last, TrackingState::kTracking);
  EXPECT_GT(outcome.written, kScans / 3);
}

INSTANTIATE_TEST_SUITE_P(Errors, PoisonTest,
                         ::testing::Values(Poison{0.3, 0, 1}, Poison{1, 0, 1}, Poison{3, 0, 1},
                                           Poison{0.3, 0, 10}, Poison{1, 0, 10}, Poison{3, 0, 10},
                                           Poison{0, 1, 1}, Poison{0, 2, 1}, Poison{0, 5, 1},
                                           Poison{0, 1, 10}, Poison{0, 2, 10}, Poison{0, 5, 10}));

TEST(Localizer, StartsFromAPoseThatIsAMetreOff) {
  Twist error = Twist::Zero();
  error.head<3>() = Eigen::Vector3d(0.7, -0.6, 0.1);
  error[5] = 0.1;
  const Outcome outcome = drive_with(Twist::Zero(), 0, 0, error);
  EXPECT_LT(outcome.worst_written, 0.02);
  EXPECT_EQ(outcome.last, TrackingState::kTracking);
}

TEST(Localizer, FindsItselfWithinFiveMetres) {
  Twist error = Twist::Zero();
  error.head<3>() = Eigen::Vector3d(4.3, -3.6, 0.1);
  error[5] = -0.3;
  const Outcome outcome = drive_with(Twist::Zero(), 0, 0, error);
  EXPECT_LT(outcome.worst_written, 0.02);
  EXPECT_EQ(outcome.last, TrackingState::kTracking);
}

TEST(Localizer, RefusesScansThatAreNotLater) {
  Localizer localizer(drive().truth(0), {});
  localizer.localize(drive().survey(), drive().scan(0), 1.0, std::nullopt);
  for (const double time : {1.0, 0.5}) {
    const Localization at = localizer.localize(drive().survey(), drive().scan(1), time, std::nullopt);
    EXPECT_EQ(at.objection, "is not later than the scan before");
    EXPECT_FALSE(localizer.may_update());
  }
}

TEST(Localizer, AnEmptyWorldLosesIt) {
  Localizer localizer(Pose{}, {});
  for (int i = 0; i < 7; ++i) {
    const Localization at = localizer.localize(Octree(VoxelGrid{0.4}), Scan{}, i, std::nullopt);
    EXPECT_EQ(at.state, i < 4 ? TrackingState::kDegraded : TrackingState::kLost);
    EXPECT_EQ(at.T_map_sensor.translation, Eigen::Vector3d::Zero());
  }
}

TEST(Localizer, EqualBaysAreAmbiguous) {
  Scene aisle = test::plane();
  for (int i = -15; i <= 15; ++i) {
    for (const double y : {-3.0, 3.0}) {
      Pose T_map_bay;
      T_map_bay.translation = {3.0 * i, y, -0.2};
      add_box(aisle, 1000 + 2 * i + (y > 0), T_map_bay, {1.4, 1, 3});
    }
  }
  const Octree map = test::survey_map(aisle, 0.4);
  const Scan scan = Simulator(aisle).scan(Pose{}, test::small_lidar(), 1);
  const Registration found = relocate(map, scan, Pose{}, {}, {}, {});
  EXPECT_EQ(found.outcome, RegistrationOutcome::kAmbiguous) << to_string(found);
}

}  // namespace
}  // namespace evermap
