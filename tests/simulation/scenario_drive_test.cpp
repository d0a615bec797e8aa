// SPDX-FileCopyrightText: 2026 the evermap authors
// SPDX-License-Identifier: BSD-3-Clause
#include <cmath>
#include <cstring>
#include <map>
#include <numbers>
#include <set>
#include <thread>

#include <gtest/gtest.h>

#include "files/file_fixture.hpp"
#include <evermap/simulation/change_truth.hpp>
#include <evermap/simulation/scenario_drive.hpp>
#include <evermap/simulation/simulator.hpp>
#include <evermap/simulation/surface_index.hpp>

namespace evermap {
namespace {

// A world with one of everything that changes, small enough to be quick.
const std::string kWorld = R"(
scans: 20
lidar: {channels: 32, columns: 256}
ground: {area: [-30, -30, 30, 30], spacing: 1, features: [{waves: {amplitude: 0.3, length: [25, 31]}}]}
robot:
  sensor_height: 2
  route: {speed: 8, turn_radius: 6, waypoints: [[-12, -6], [6, -6], [6, 10]]}
objects:
  - {name: house, box: [8, 6, 5], at: [-10, 14, 20]}
  - {name: truck, body: truck, route: {speed: 6, turn_radius: 5, waypoints: [[-20, 4], [0, 2], [0, 30]]}}
  - {name: pile, pile: {height: [[0, 1.5], [2, 3]]}, at: [14, -2]}
  - {name: gone, box: [2, 2, 2], at: [-2, -14], survey: only}
  - {name: come, box: [2, 2, 2], at: [6, -16], survey: absent}
  - {name: moved, body: car, at: [-16, -16, 30], survey: {at: [-15, -16, 30]}}
)";
constexpr int kTruck = 2;
constexpr int kPile = 3;

class ScenarioDriveTest : public FileTest {
 protected:
  Scenario read(const std::string& text = kWorld) const { return read_scenario(make("world.yaml", text)); }
  static std::string replaced(std::string text, const std::string& from, const std::string& to) {
    text.replace(text.find(from), from.size(), to);
    return text;
  }
};

bool same(const LabelledScan& a, const LabelledScan& b) {
  return a.object == b.object && a.scan.p_sensor == b.scan.p_sensor &&
         a.scan.time_offset == b.scan.time_offset;
}

/// The triangles of one object.
Scene only(const Scene& scene, int object) {
  Scene part;
  part.vertices = scene.vertices;
  for (std::size_t i = 0; i < scene.triangles.size(); ++i) {
    if (ScenarioDrive::object_of(scene.object[i]) != object) continue;
    part.triangles.push_back(scene.triangles[i]);
    part.object.push_back(scene.object[i]);
  }
  return part;
}

std::map<int, int> count_by_object(const LabelledScan& scan) {
  std::map<int, int> count;
  for (const int object : scan.object) ++count[object];
  return count;
}

TEST_F(ScenarioDriveTest, AScanDependsOnItsScenarioAndNumberAlone) {
  const ScenarioDrive one(read());
  const ScenarioDrive two(read());
  const LabelledScan first = one.scan(3);
  const LabelledScan second = one.scan(9);
  EXPECT_TRUE(same(second, two.scan(9)));
  EXPECT_TRUE(same(first, two.scan(3)));
  Scenario other = read();
  other.seed = 2;
  EXPECT_FALSE(same(first, ScenarioDrive(other).scan(3)));
  EXPECT_GT(first.object.size(), 3000u);
}

TEST_F(ScenarioDriveTest, ThreadsDoNotDisturbEachOther) {
  const ScenarioDrive drive(read());
  const LabelledScan expected = drive.scan(5);
  std::vector<LabelledScan> scans(4);
  std::vector<std::thread> threads;
  for (LabelledScan& scan : scans) threads.emplace_back([&] { scan = drive.scan(5); });
  for (std::thread& thread : threads) thread.join();
  for (const LabelledScan& scan : scans) EXPECT_TRUE(same(scan, expected));
}

TEST_F(ScenarioDriveTest, NoiseOfTwoScansIsNotTheSame) {
  Scenario standing = read(replaced(
      kWorld, "route: {speed: 8, turn_radius: 6, waypoints: [[-12, -6], [6, -6], [6, 10]]}", "at: [0, 0]"));
  const ScenarioDrive drive(standing);
  EXPECT_NE(drive.scan(0).scan.p_sensor[0], drive.scan(1).scan.p_sensor[0]);
}

TEST_F(ScenarioDriveTest, ScansAreStampedWithTheirEnd) {
  const ScenarioDrive drive(read());
  EXPECT_NEAR(drive.time(0), 0.1, 1e-12);
  EXPECT_NEAR(drive.time(19), 2.0, 1e-12);
  EXPECT_NEAR(drive.T_map_sensor(0).translation.x(), -12 + 0.8, 0.1) << "leaning with the ground";
}

TEST_F(ScenarioDriveTest, EveryPointIsOnTheObjectThatItsLabelNames) {
  const ScenarioDrive drive(read());
  std::map<int, int> seen;
  for (const std::size_t i : {0, 7, 15}) {
    const Scene scene = drive.scene(i);
    const LabelledScan labelled = drive.scan(i);
    const auto p_map = drive.in_map(i, labelled.scan);
    for (const auto& [object, count] : count_by_object(labelled)) {
      seen[object] += count;
      const Scene part = only(scene, object);
      const SurfaceIndex index(part);
      for (std::size_t k = 0; k < p_map.size(); ++k) {
        if (labelled.object[k] != object) continue;
        ASSERT_LT(index.distance(p_map[k], 0.2), 6 * drive.scenario().lidar.range_sigma)
            << drive.name_of(object);
      }
    }
  }
  EXPECT_GT(seen[kTruck], 50);
  EXPECT_EQ(seen.size(), 6u) << "ground, house, truck, pile, come, moved";
  EXPECT_EQ(drive.name_of(kTruck), "truck");
  EXPECT_EQ(drive.class_of(kTruck), ObjectClass::kHighDynamic);
  EXPECT_EQ(drive.class_of(0), ObjectClass::kStatic);
}

TEST_F(ScenarioDriveTest, TheTruckDrives) {
  const ScenarioDrive drive(read());
  const auto middle = [&](std::size_t i) {
    Eigen::AlignedBox3d bounds;
    const Scene truck = only(drive.scene(i), kTruck);
    for (std::size_t t = 0; t < truck.triangles.size(); ++t) bounds.extend(truck.triangle(t).a);
    return Eigen::Vector3d(bounds.center());
  };
  EXPECT_NEAR((middle(10) - middle(0)).norm(), 6, 0.1);
}

TEST_F(ScenarioDriveTest, APilesVolumeFollowsItsSchedule) {
  const ScenarioDrive drive(read(replaced(kWorld, "{amplitude: 0.3", "{amplitude: 0")));
  const auto volume = [&](std::size_t i) {
    const Simulator simulator(only(drive.scene(i), kPile));
    constexpr double kStep = 0.1;
    double sum = 0;
    for (double x = 6; x < 22; x += kStep) {
      for (double y = -10; y < 6; y += kStep) {
        const auto range = simulator.range({x, y, 10}, {0, 0, -1});
        if (range) sum += std::max(0.0, 10 - *range) * kStep * kStep;
      }
    }
    return sum;
  };
  const double grade = std::tan(35 * std::numbers::pi / 180);
  for (const std::size_t i : {0, 9, 19}) {
    const double height = 1.5 + 1.5 * drive.time(i) / 2;
    const double cone = std::numbers::pi * std::pow(height, 3) / (3 * grade * grade);
    // The blunt tip makes a pile wider than the cone of its height.
    EXPECT_GT(volume(i), cone) << i;
    const double blunt = std::numbers::pi * std::pow(height + 0.3 * grade, 3) / (3 * grade * grade);
    EXPECT_LT(volume(i), blunt) << i;
  }
}

TEST_F(ScenarioDriveTest, MotionDistortionIsUndoneByThePosesOfTheColumns) {
  const ScenarioDrive drive(
      read(replaced(kWorld, "columns: 256}", "columns: 256, motion_distortion: true}")));
  const LabelledScan labelled = drive.scan(8);
  ASSERT_EQ(labelled.scan.time_offset.size(), labelled.scan.p_sensor.size());
  EXPECT_LT(labelled.scan.time_offset.back(), 0.1F);
  EXPECT_GT(labelled.scan.time_offset.back(), 0.09F);
  const Scene scene = drive.scene(8);
  const SurfaceIndex index(scene);
  const auto undone = drive.in_map(8, labelled.scan);
  int far_off = 0;
  for (std::size_t k = 0; k < labelled.object.size(); ++k) {
    const double moment = drive.time(8) - 0.1 + double{labelled.scan.time_offset[k]};
    const Eigen::Vector3d p_map = drive.T_map_sensor_at(moment) * labelled.scan.p_sensor[k];
    ASSERT_LT(index.distance(p_map, 0.5), 0.12);
    ASSERT_LT((p_map - undone[k]).norm(), 1e-9);
    if (index.distance(drive.T_map_sensor(8) * labelled.scan.p_sensor[k], 0.2) > 0.12) ++far_off;
  }
  EXPECT_GT(far_off, 100) << "nothing was distorted";
}

TEST_F(ScenarioDriveTest, WithoutMotionDistortionThereAreNoTimes) {
  EXPECT_TRUE(ScenarioDrive(read()).scan(0).scan.time_offset.empty());
}

TEST_F(ScenarioDriveTest, DropoutTakesGrazingAndDarkSurfaces) {
  const std::string text = R"(
scans: 1
lidar: {range_sigma: 0}
ground: {area: [-60, -60, 60, 60], spacing: 20}
robot: {sensor_height: 2, at: [0, 0]}
objects:
  - {name: bright, box: [0.2, 40, 8], at: [30, 0], reflectivity: 0.9}
  - {name: dark, box: [0.2, 40, 8], at: [-30, 0], reflectivity: 0.1}
)";
  const LabelledScan full = ScenarioDrive(read(text)).scan(0);
  const LabelledScan less =
      ScenarioDrive(read(replaced(text, "range_sigma: 0", "range_sigma: 0, dropout_range: 150"))).scan(0);
  const auto share = [&](const auto& wanted) {
    const auto count = [&](const LabelledScan& scan) {
      double n = 0;
      for (std::size_t i = 0; i < scan.object.size(); ++i)
        n += wanted(scan.object[i], scan.scan.p_sensor[i]) ? 1 : 0;
      return n;
    };
    EXPECT_GT(count(full), 500);
    return count(less) / count(full);
  };
  const double steep =
      share([](int object, const Eigen::Vector3d& p) { return object == 0 && p.norm() < 6; });
  const double grazing =
      share([](int object, const Eigen::Vector3d& p) { return object == 0 && p.norm() > 25; });
  const double bright = share([](int object, const Eigen::Vector3d&) { return object == 1; });
  const double dark = share([](int object, const Eigen::Vector3d&) { return object == 2; });
  EXPECT_GT(steep, 0.99);
  EXPECT_LT(grazing, 0.3);
  EXPECT_GT(bright, 0.99);
  EXPECT_LT(dark, 0.95);
}

TEST_F(ScenarioDriveTest, HalfOfTheBeamsComeBackFromAWhiteWallAtTheDropoutRange) {
  const ScenarioDrive drive(read(R"(
scans: 1
lidar: {elevation: [-1, 1], dropout_range: 30}
ground: {area: [-60, -60, 60, 60], spacing: 20}
robot: {sensor_height: 10, at: [0, 0]}
objects:
  - {name: white, box: [0.2, 4, 20], at: [30.1, 0], reflectivity: 1}
)"));
  Scenario all = drive.scenario();
  all.dropout_range.reset();
  const auto count = [](const ScenarioDrive& of) {
    return static_cast<double>(count_by_object(of.scan(0))[1]);
  };
  EXPECT_NEAR(count(drive) / count(ScenarioDrive(all)), 0.5, 0.05);
}

TEST_F(ScenarioDriveTest, TruthIsWhatANoiselessBeamMeets) {
  Scenario scenario = read();
  scenario.lidar.range_sigma = 0;
  const ScenarioDrive drive(scenario);
  const Scene scene = drive.scene(12);
  const Simulator simulator(scene);
  const Eigen::Vector3d origin = drive.T_map_sensor(12).translation;
  const auto truth = drive.truth(12, 0.2);
  std::map<int, int> met;
  for (const SurfaceSample& sample : truth) {
    const double distance = (sample.p_map - origin).norm();
    const auto range = simulator.range(origin, sample.p_map - origin);
    ASSERT_TRUE(range && *range < distance + 1e-3) << "a beam went through the truth";
    if (*range > distance - 1e-3) ++met[sample.object];
  }
  EXPECT_EQ(met.size(), 6u);
  EXPECT_GT(met[0], 10000);

  // And every return is near the truth.
  const SurfaceIndex surface(scene);
  for (const Eigen::Vector3d& p : drive.in_map(12, drive.scan(12).scan))
    ASSERT_LT(surface.distance(p, 0.1), 1e-6);
}

TEST_F(ScenarioDriveTest, TheSurveyDiffersFromTheRunAtTheNamedObjectsOnly) {
  const ScenarioDrive drive(
      read(replaced(kWorld, "pile: {height: [[0, 1.5], [2, 3]]}", "pile: {height: 2}")));
  const Scene before = drive.survey_scene();
  const Scene now = drive.scene(19);
  const std::set<std::string> changed = {"truck", "gone", "come", "moved"};
  const auto near_changed = [&](const Scene& scene, const Eigen::Vector3d& p) {
    for (int object = 1; object <= 6; ++object) {
      const Scene part = only(scene, object);
      if (!changed.contains(drive.name_of(object)) || part.triangles.empty()) continue;
      const SurfaceIndex index(part);
      if (index.distance(p, 0.02) < 0.02 || index.buried(p + Eigen::Vector3d(0, 0, 0.2))) return true;
    }
    return false;
  };
  const ChangeTruth truth = change_truth(before, now, 0.2, 0.1);
  EXPECT_GT(truth.removed.size(), 300u);
  EXPECT_GT(truth.added.size(), 1000u);
  EXPECT_GT(truth.unchanged.size(), 50000u);
  for (const auto& p : truth.removed) EXPECT_TRUE(near_changed(before, p)) << p.transpose();
  for (const auto& p : truth.added)
    EXPECT_TRUE(near_changed(now, p) || near_changed(before, p)) << p.transpose();
}

TEST_F(ScenarioDriveTest, TheSurveyIsTheSurfaceOfItsScene) {
  const ScenarioDrive drive(read());
  EXPECT_EQ(drive.survey(0.3).size(), sample_surface(drive.survey_scene(), 0.3).size());
  for (const SurfaceSample& sample : drive.truth(0, 0.3)) EXPECT_NE(drive.name_of(sample.object), "gone");
}

void expect_refused(const Scenario& scenario, int line, const std::string& message) {
  try {
    const ScenarioDrive drive(scenario);
    ADD_FAILURE() << "no error: " << message;
  } catch (const FileError& error) {
    const std::string what = error.what();
    EXPECT_NE(what.find("world.yaml: at line " + std::to_string(line) + ": "), std::string::npos) << what;
    EXPECT_NE(what.find(message), std::string::npos) << what;
  }
}

TEST_F(ScenarioDriveTest, RefusesAnObjectThatContainsTheSensor) {
  expect_refused(read(replaced(kWorld, "at: [-10, 14, 20]", "at: [0.4, -6]")), 9,
                 "house contains the sensor at scan 10");
  expect_refused(read(replaced(kWorld, "[[-20, 4], [0, 2], [0, 30]]", "[[-10, -5], [4, -5]]")), 10,
                 "truck contains the sensor");
  expect_refused(read(replaced(kWorld, "at: [14, -2]", "at: [0, -6]")), 11, "pile contains the sensor");
}

TEST_F(ScenarioDriveTest, RefusesARobotThatLeavesTheGround) {
  expect_refused(read(replaced(kWorld, "[[-12, -6], [6, -6], [6, 10]]", "[[-20, -6], [-40, -6]]")), 5,
                 "the robot leaves the ground's area at scan");
}

}  // namespace
}  // namespace evermap
