// SPDX-FileCopyrightText: 2026 the evermap authors
// SPDX-License-Identifier: BSD-3-Clause
#include <algorithm>
#include <cmath>
#include <iterator>
#include <numeric>
#include <ostream>
#include <string>
#include <tuple>
#include <utility>
#include <vector>

#include <gtest/gtest.h>

#include "localization/worlds.hpp"
#include <evermap/localization/detail/localizer.hpp>
#include <evermap/localization/detail/perturbation.hpp>
#include <evermap/localization/detail/relocation.hpp>
#include <evermap/maintenance/map_maintainer.hpp>
#include <evermap/simulation/surface_index.hpp>

namespace evermap {
namespace {

using test::kPeriod;

Twist twist(double x, double y, double z, double yaw) {
  Twist twist;
  twist << x, y, z, 0, 0, yaw;
  return twist;
}

/// To and fro along the yard's drive, through the yard as it is now.
class Drive {
 public:
  explicit Drive(const Scene& now) {
    const Simulator simulator(now);
    for (std::size_t i = 0; i < test::yard().size(); ++i) {
      scans_.push_back(simulator.scan(test::yard().T_map_sensor(i), test::small_lidar(), i));
    }
  }
  Pose truth(std::size_t i) const { return test::yard().T_map_sensor(place(i)); }
  const Scan& scan(std::size_t i) const { return scans_[place(i)]; }

 private:
  std::size_t place(std::size_t i) const {
    const std::size_t last = scans_.size() - 1;
    return i / last % 2 == 0 ? i % last : last - i % last;
  }
  std::vector<Scan> scans_;
};
const Drive& drive() {
  static const Drive the_drive(test::yard().scene(0));
  return the_drive;
}
const Octree& survey() {
  static const Octree octree = test::survey_map(test::yard().survey_scene(), 0.4);
  return octree;
}

/// What a scan and the odometry are like in a run: they may be taken from elsewhere or be wrong.
struct Reading {
  Pose truth;
  const Scan* scan;
  Pose T_odom_sensor;
};
Reading reading(std::size_t i) { return {drive().truth(i), &drive().scan(i), drive().truth(i)}; }

struct Outcome {
  Octree map{VoxelGrid{}};
  double worst_written = 0;     ///< [m] error of a pose that was written into the map
  std::vector<double> errors;   ///< [m] of each scan's pose
  double worst_tracked = 0;     ///< [m] error of a pose while tracking
  std::size_t refused = 0;      ///< scans that were not written
  std::size_t first_alarm = 0;  ///< scan at which the state first was neither starting nor tracking; 0: never
  TrackingState last = TrackingState::kLost;
};

template <class ReadingOf>
Outcome run_loop(std::size_t scans, const Pose& start, Octree map_at_start, const ReadingOf& reading_of) {
  MapMaintainer maintainer(std::move(map_at_start), {}, MapMode::kMaintenance, start);
  Outcome outcome;
  for (std::size_t i = 0; i < scans; ++i) {
    const Reading now = reading_of(i);
    const ScanResult at = maintainer.process(*now.scan, kPeriod * static_cast<double>(i), now.T_odom_sensor);
    const double error = difference(now.truth, at.T_map_sensor).head<3>().norm();
    outcome.errors.push_back(error);
    if (at.is_written) outcome.worst_written = std::max(outcome.worst_written, error);
    if (at.state == TrackingState::kTracking) outcome.worst_tracked = std::max(outcome.worst_tracked, error);
    outcome.refused += at.is_written ? 0 : 1;
    const bool alarm = at.state == TrackingState::kDegraded || at.state == TrackingState::kLost;
    if (alarm && outcome.first_alarm == 0) outcome.first_alarm = i;
    outcome.last = at.state;
  }
  outcome.map = maintainer.map();
  return outcome;
}

/// Fraction of the survey's wall that the map has no longer. Nothing else reaches so far out and up.
double fraction_of_walls_lost(const Octree& map) {
  double walls = 0;
  double lost = 0;
  survey().for_each_leaf([&](VoxelKey key, const Leaf& leaf) {
    const Eigen::Vector3d p = map.grid().center(key);
    if (!leaf.occupied() || p.head<2>().cwiseAbs().maxCoeff() < 28 || p.z() < 1) return;
    const Leaf* now = map.find(key);
    walls += 1;
    lost += now == nullptr || !now->occupied();
  });
  return lost / walls;
}

/// Fraction of the map's leaves that are farther than a leaf from all that is or was there.
double fraction_of_phantoms(const Octree& map) {
  const Scene survey_scene = test::yard().survey_scene();
  const Scene scene = test::yard().scene(0);
  const SurfaceIndex before(survey_scene);
  const SurfaceIndex now(scene);
  const double edge = map.grid().edge;
  double phantoms = 0;
  map.for_each_leaf([&](VoxelKey key, const Leaf& leaf) {
    const Eigen::Vector3d p = map.gaussian(key, leaf).mean;
    phantoms += leaf.occupied() && before.distance(p, edge) > edge && now.distance(p, edge) > edge;
  });
  return phantoms / static_cast<double>(map.leaf_count());
}

/// Something that goes wrong with the odometry, or with the robot, for some scans.
struct Poison {
  std::string name;
  Reading (*reading)(std::size_t i);
};
Reading off_by(std::size_t i, const Twist& error) {
  Reading r = reading(i);
  r.T_odom_sensor = perturb(r.T_odom_sensor, error);
  return r;
}
void PrintTo(const Poison& poison, std::ostream* out) { *out << poison.name; }
const std::vector<Poison>& poisons() {
  static const std::vector<Poison> list{
      {"ThirdOfAMetre", [](std::size_t i) { return off_by(i, twist(0.3, 0, 0, 0)); }},
      {"OneMetre", [](std::size_t i) { return off_by(i, twist(0, 1, 0, 0)); }},
      {"ThreeMetres", [](std::size_t i) { return off_by(i, twist(3, 0, 0, 0)); }},
      {"OneDegree", [](std::size_t i) { return off_by(i, twist(0, 0, 0, kDegree)); }},
      {"TwoDegrees", [](std::size_t i) { return off_by(i, twist(0, 0, 0, 2 * kDegree)); }},
      {"FiveDegrees", [](std::size_t i) { return off_by(i, twist(0, 0, 0, 5 * kDegree)); }},
      {"LateBy100Milliseconds",
       [](std::size_t i) {
         Reading r = reading(i);
         r.T_odom_sensor = drive().truth(i - 1);
         return r;
       }},
      {"WrongExtrinsic",
       [](std::size_t i) {
         Reading r = reading(i);
         r.T_odom_sensor = r.T_odom_sensor * exp(twist(0.5, 0.2, 0, 5 * kDegree));
         return r;
       }},
      // Someone carries the robot to where it will be in three seconds, and back; its wheels notice nothing.
      {"Kidnapped",
       [](std::size_t i) {
         Reading r = reading(i + 30);
         r.T_odom_sensor = drive().truth(i);
         return r;
       }},
  };
  return list;
}

class PoisonTest : public ::testing::TestWithParam<std::tuple<Poison, std::size_t>> {};

TEST_P(PoisonTest, NeverDamagesTheMap) {
  constexpr std::size_t kBegin = 10;
  const auto& [poison, scans] = GetParam();
  const std::size_t end = kBegin + scans;
  const Outcome outcome = run_loop(end + 20, drive().truth(0), survey(), [&, &wrong = poison](std::size_t i) {
    return i >= kBegin && i < end ? wrong.reading(i) : reading(i);
  });
  EXPECT_LT(outcome.worst_written, 0.02);
  EXPECT_LE(fraction_of_walls_lost(outcome.map), 0.01);
  EXPECT_LE(fraction_of_phantoms(outcome.map), 0.001);
  EXPECT_EQ(outcome.last, TrackingState::kTracking) << "never found back";
  // What registration can mend is no reason for an alarm.
  const bool was_told = outcome.first_alarm >= kBegin && outcome.first_alarm <= kBegin + 5;
  EXPECT_TRUE(was_told || outcome.worst_tracked < 0.02) << outcome.first_alarm;
}

INSTANTIATE_TEST_SUITE_P(All, PoisonTest,
                         ::testing::Combine(::testing::ValuesIn(poisons()),
                                            ::testing::Values<std::size_t>(1, 10, 100)),
                         [](const auto& parameters) {
                           return std::get<0>(parameters.param).name + "For" +
                                  std::to_string(std::get<1>(parameters.param)) + "Scans";
                         });

TEST(Localizer, TracksADriveWithoutOdometry) {
  MapMaintainer localizer(survey(), {}, MapMode::kLocalization, drive().truth(0));
  std::size_t tracked = 0;
  for (std::size_t i = 0; i < 40; ++i) {
    const ScanResult at = localizer.process(drive().scan(i), kPeriod * static_cast<double>(i));
    EXPECT_FALSE(at.is_written);
    EXPECT_LT((at.T_map_sensor.translation - drive().truth(i).translation).norm(), 0.01);
    tracked += at.state == TrackingState::kTracking;
    EXPECT_FALSE(i < 2 && at.state == TrackingState::kTracking);
  }
  EXPECT_EQ(tracked, 40U - 2);  // the motion is known after two
}

TEST(Localizer, WritesAllOfACleanRunButItsFirstScan) {
  const Outcome outcome = run_loop(110, drive().truth(0), survey(), reading);
  EXPECT_LE(outcome.refused, 2U);  // the motion is not known before the second scan
  EXPECT_EQ(outcome.first_alarm, 0U);
  EXPECT_LT(outcome.worst_written, 0.01);
}

// Boxes all over the yard came, and others went.
TEST(Localizer, WritesMostScansWhereAThirdOfTheSceneHasChanged) {
  std::vector<Eigen::Vector3d> places;
  for (std::size_t i = 0; i < test::yard().size(); ++i) places.push_back(drive().truth(i).translation);
  const auto with_boxes = [&](Scene scene, double shift) {
    int object = 1'000'000;
    for (double x = -24; x < 25; x += 8) {
      for (double y = -24; y < 25; y += 8) {
        Pose T_map_box;
        T_map_box.translation = {x + shift, y + shift, 1};
        const bool is_in_the_way = std::any_of(places.begin(), places.end(), [&](const auto& p) {
          return (p - T_map_box.translation).template head<2>().norm() < 4;
        });
        if (!is_in_the_way) add_box(scene, object++, T_map_box, {2, 3, 3});
      }
    }
    return scene;
  };
  const Scene before = with_boxes(test::yard().survey_scene(), 0);
  const Scene now = with_boxes(test::yard().scene(0), 4);
  const Octree map = test::survey_map(before, 0.4);
  const Drive changed(now);
  std::size_t hits = 0;
  std::size_t new_hits = 0;
  for (std::size_t i = 0; i < 60; i += 10) {
    for (const Eigen::Vector3d& p : changed.scan(i).p_sensor) {
      const auto key = map.grid().key(changed.truth(i) * p);
      ++hits;
      new_hits += !key || map.find(*key) == nullptr;
    }
  }
  EXPECT_GT(static_cast<double>(new_hits), 0.3 * static_cast<double>(hits)) << "the test changes too little";
  const Outcome outcome = run_loop(110, changed.truth(0), map, [&](std::size_t i) {
    return Reading{changed.truth(i), &changed.scan(i), changed.truth(i)};
  });
  EXPECT_LE(outcome.refused, 2U + 5U);
  EXPECT_LT(outcome.worst_written, 0.02);
}

TEST(Localizer, StandsStillFor3000Scans) {
  const Simulator simulator(test::yard().scene(0));
  const Pose truth = test::yard().T_map_sensor(20);
  Scan scan;
  const Outcome outcome = run_loop(3000, truth, survey(), [&](std::size_t i) {
    scan = simulator.scan(truth, test::small_lidar(), i);
    return Reading{truth, &scan, truth};
  });
  EXPECT_EQ(outcome.first_alarm, 0U);
  EXPECT_LT(outcome.worst_tracked, 0.015);
  const auto mean = [](auto begin, auto end) {
    return std::accumulate(begin, end, 0.0) / static_cast<double>(std::distance(begin, end));
  };
  const auto& errors = outcome.errors;
  EXPECT_LT(mean(errors.end() - 300, errors.end()), mean(errors.begin(), errors.begin() + 300) + 0.002);
  EXPECT_LE(fraction_of_walls_lost(outcome.map), 0.001);
}

TEST(Localizer, StartsFromAPoseThatIsAMetreOff) {
  const Pose start = perturb(drive().truth(0), twist(0.7, -0.6, 0.1, 0.1));
  const Outcome outcome = run_loop(20, start, survey(), reading);
  EXPECT_LT(outcome.worst_written, 0.02);
  EXPECT_EQ(outcome.last, TrackingState::kTracking);
}

TEST(Localizer, FindsItselfWithinFiveMetres) {
  const Pose start = perturb(drive().truth(0), twist(4.3, -3.6, 0.1, -0.3));
  const Outcome outcome = run_loop(20, start, survey(), reading);
  EXPECT_LT(outcome.worst_written, 0.02);
  EXPECT_EQ(outcome.last, TrackingState::kTracking);
}

// Of a sensor in motion the first scan alone is distorted, and may not be found; odometry tells the motion to
// the next.
TEST(Localizer, OdometryMovesTheGuessOfAStart) {
  Localizer localizer(drive().truth(0), {}, {});
  const Pose T_moved = exp(twist(0.8, 0, 0, 0.1));
  EgoMotion ego{Pose{}, {}};
  Localization found = localizer.propose(survey(), Scan{}, 0, ego);
  ASSERT_FALSE(found.passes());
  localizer.conclude(found);
  ego.T_odom_sensor = T_moved;
  const Pose expected = drive().truth(0) * T_moved;
  EXPECT_LT(difference(expected, localizer.predict(kPeriod, ego)).norm(), 1e-9);
  Scan moving = drive().scan(5);
  for (std::size_t i = 0; i < moving.p_sensor.size(); ++i)
    moving.time_offset.push_back(
        static_cast<float>(kPeriod * static_cast<double>(i) / static_cast<double>(moving.p_sensor.size())));
  found = localizer.propose(survey(), moving, kPeriod, ego);
  EXPECT_LT((found.velocity - log(T_moved) / kPeriod).norm(), 1e-6) << "no other speeds are tried";
}

// Registration comes to rest there only when it begins within some decimetres.
TEST(Localizer, LooksForPlacesBeside) {
  const Pose& truth = drive().truth(20);
  for (const auto& [x, y] : {std::pair{0.5, 0.0}, {-0.3, 0.4}, {0.2, -0.5}}) {
    Pose off = truth;
    off.translation += Eigen::Vector3d(x, y, 0);
    const auto beside = places_beside(survey(), drive().scan(20), {off}, {}, {});
    EXPECT_TRUE(std::any_of(beside.begin(), beside.end(), [&](const Registration& place) {
      return place.converged() && difference(truth, place.T_map_sensor).head<3>().norm() < 0.01;
    }));
  }
}

TEST(Localizer, RefusesScansThatAreNotLater) {
  MapMaintainer localizer(survey(), {}, MapMode::kLocalization, drive().truth(0));
  localizer.process(drive().scan(0), 1.0);
  for (const double time : {1.0, 0.5}) {
    const ScanResult at = localizer.process(drive().scan(1), time);
    EXPECT_EQ(at.reject_reason, RejectReason::kTimeNotLater);
    EXPECT_NE(at.state, TrackingState::kTracking);
  }
}

TEST(Localizer, AScanThatItsCallerRejectsDidNotPass) {
  Localizer localizer(drive().truth(0), {}, {});
  for (std::size_t i = 0; i < 5; ++i) {
    Localization at = localizer.propose(survey(), drive().scan(i), kPeriod * static_cast<double>(i),
                                        {drive().truth(i), {}});
    EXPECT_EQ(at.is_writable(), i > 0);  // not before the motion is known
    if (at.is_writable()) at.reject_reason = RejectReason::kContradictsMap;
    localizer.conclude(at);
    EXPECT_EQ(at.state, i == 0 ? TrackingState::kStarting : TrackingState::kDegraded);
  }
}

TEST(Localizer, AnEmptyWorldLosesIt) {
  MapMaintainer localizer(Octree(VoxelGrid{0.4}), {}, MapMode::kLocalization);
  for (int i = 0; i < 7; ++i) {
    const ScanResult at = localizer.process(Scan{}, i);
    EXPECT_EQ(at.state, i < 4 ? TrackingState::kDegraded : TrackingState::kLost);
    EXPECT_EQ(at.T_map_sensor.translation, Eigen::Vector3d::Zero());
  }
}

/// An aisle of bays that look alike, 3 m apart.
Scene aisle() {
  Scene scene = test::plane();
  for (int i = -15; i <= 15; ++i) {
    for (const double y : {-3.0, 3.0}) {
      Pose T_map_bay;
      T_map_bay.translation = {3.0 * i, y, -0.2};
      add_box(scene, 1000 + 2 * i + (y > 0), T_map_bay, {1.4, 1, 3});
    }
  }
  return scene;
}

TEST(Localizer, EqualBaysAreAmbiguous) {
  const Octree map = test::survey_map(aisle(), 0.4);
  const Scan scan = Simulator(aisle()).scan(Pose{}, test::small_lidar(), 1);
  std::vector<Hypothesis> all;
  for (const Registration& place : places(map, scan, Pose{}, {}, {}, {})) all.push_back({place, scan});
  const std::vector<Hypothesis> bays = distinct(std::move(all), 0.1);
  ASSERT_GT(bays.size(), 1U);
  EXPECT_TRUE(has_rival(bays, best_of(bays), GateParameters{}.margin));
}

// The odometry slips by one bay, where everything looks the same.
TEST(Localizer, OneBayOffIsNeverWritten) {
  const Octree map = test::survey_map(aisle(), 0.4);
  const Simulator simulator(aisle());
  for (const std::size_t scans : {1, 10, 100}) {
    Scan scan;
    const Outcome outcome = run_loop(20 + scans, Pose{}, map, [&](std::size_t i) {
      Reading r;
      r.truth.translation.x() = 0.03 * static_cast<double>(i);
      scan = simulator.scan(r.truth, test::small_lidar(), i);
      r.scan = &scan;
      r.T_odom_sensor = r.truth;
      if (i >= 10 && i < 10 + scans) r.T_odom_sensor.translation.x() += 3;
      return r;
    });
    EXPECT_LT(outcome.worst_written, 0.02) << scans;
    EXPECT_GE(outcome.first_alarm, 10U);
    EXPECT_LE(outcome.first_alarm, 15U);
  }
}

}  // namespace
}  // namespace evermap
