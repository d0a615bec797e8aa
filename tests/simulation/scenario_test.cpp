// SPDX-FileCopyrightText: 2026 the evermap authors
// SPDX-License-Identifier: BSD-3-Clause
#include <numbers>
#include <variant>

#include <gtest/gtest.h>

#include "files/file_fixture.hpp"
#include <evermap/simulation/scenario.hpp>

namespace evermap {
namespace {

// Six lines, so that what a test appends begins at line 7.
const std::string kEmptyWorld =
    "scans: 3\n"
    "ground: {area: [-20, -20, 20, 20], features: [{slope: [0.1, 0]}]}\n"
    "robot:\n"
    "  sensor_height: 2\n"
    "  at: [0, 0]\n"
    "objects:\n";

class ScenarioTest : public FileTest {
 protected:
  Scenario read(const std::string& text) const { return read_scenario(make("world.yaml", text)); }
  Scenario with(const std::string& objects) const { return read(kEmptyWorld + objects); }

  void expect_refused(const std::string& text, int line, const std::string& message) const {
    const std::filesystem::path file = make("world.yaml", text);
    try {
      read_scenario(file);
      ADD_FAILURE() << "no error: " << message;
    } catch (const FileError& error) {
      const std::string what = error.what();
      EXPECT_TRUE(what.starts_with(file.string() + ": at line " + std::to_string(line) + ": ")) << what;
      EXPECT_NE(what.find(message), std::string::npos) << what << " lacks: " << message;
      EXPECT_EQ(what.find('\n'), std::string::npos) << what;
    }
  }
  void expect_object_refused(const std::string& object, const std::string& message) const {
    expect_refused(kEmptyWorld + object + "\n", 7, message);
  }
};

TEST_F(ScenarioTest, LeavesTheLidarAtItsDefaults) {
  const Scenario scenario = read(kEmptyWorld);
  EXPECT_EQ(scenario.lidar.channels, 64);
  EXPECT_EQ(scenario.lidar.columns, 1024);
  EXPECT_EQ(scenario.lidar.rate, 10);
  EXPECT_FALSE(scenario.dropout_range);
  EXPECT_FALSE(scenario.motion_distortion);
  EXPECT_EQ(scenario.seed, 1u);
  EXPECT_EQ(scenario.scans, 3);
  EXPECT_TRUE(scenario.objects.empty());
  EXPECT_NEAR(scenario.ground(5, 1), 0.5, 1e-12);
}

TEST_F(ScenarioTest, ReadsTheLidar) {
  const Scenario scenario = read(
      "lidar: {channels: 8, columns: 90, elevation: [-10, 5], rate: 5, min_range: 1, max_range: 50,"
      " range_sigma: 0, dropout_range: 100, motion_distortion: true}\nseed: 18446744073709551\n" +
      kEmptyWorld);
  EXPECT_EQ(scenario.lidar.beams(), 720);
  EXPECT_NEAR(scenario.lidar.elevation_min, -10 * std::numbers::pi / 180, 1e-12);
  EXPECT_NEAR(scenario.lidar.elevation_max, 5 * std::numbers::pi / 180, 1e-12);
  EXPECT_EQ(scenario.lidar.range_sigma, 0);
  EXPECT_EQ(scenario.dropout_range, 100);
  EXPECT_TRUE(scenario.motion_distortion);
  EXPECT_EQ(scenario.seed, 18446744073709551u);
}

TEST_F(ScenarioTest, AnObjectAtSeveralPlacesIsSeveralObjects) {
  const Scenario scenario = with("- {name: pole, post: {height: 3}, places: [[1, 2], [3, 4, 90]]}\n");
  ASSERT_EQ(scenario.objects.size(), 2u);
  EXPECT_EQ(scenario.objects[0].name, "pole/1");
  EXPECT_EQ(scenario.objects[1].name, "pole/2");
  EXPECT_EQ(scenario.objects[1].run->where.place.xy, Eigen::Vector2d(3, 4));
  EXPECT_NEAR(scenario.objects[1].survey->where.place.yaw, std::numbers::pi / 2, 1e-12);
}

TEST_F(ScenarioTest, TheSurveySaysWhatWasDifferent) {
  const Scenario scenario = with(
      "- {name: same, box: [1, 1, 1], at: [5, 5]}\n"
      "- {name: absent, box: [1, 1, 1], at: [5, 5], survey: absent}\n"
      "- {name: only, box: [1, 1, 1], at: [5, 5], survey: only}\n"
      "- {name: moved, box: [1, 1, 1], at: [5, 5], survey: {at: [6, 5]}}\n"
      "- {name: grown, heap: {radius: 2, height: 2}, at: [5, 5], survey: {heap: {radius: 1, height: 1}}}\n"
      "- {name: walker, body: person, route: {speed: 1, waypoints: [[1, 1], [2, 2]]}}\n");
  const auto& objects = scenario.objects;
  EXPECT_TRUE(objects[0].survey && objects[0].run);
  EXPECT_TRUE(!objects[1].survey && objects[1].run);
  EXPECT_TRUE(objects[2].survey && !objects[2].run);
  EXPECT_EQ(objects[3].survey->where.place.xy, Eigen::Vector2d(6, 5));
  EXPECT_EQ(objects[3].run->where.place.xy, Eigen::Vector2d(5, 5));
  EXPECT_EQ(std::get<HeapShape>(objects[4].survey->shape).radius, 1);
  EXPECT_EQ(std::get<HeapShape>(objects[4].run->shape).radius, 2);
  EXPECT_FALSE(objects[5].survey);

  EXPECT_EQ(objects[0].object_class, ObjectClass::kStatic);
  for (const std::size_t i : {1, 2, 3, 4}) EXPECT_EQ(objects[i].object_class, ObjectClass::kLowDynamic) << i;
  EXPECT_EQ(objects[5].object_class, ObjectClass::kHighDynamic);
}

TEST_F(ScenarioTest, TheClassFollowsFromWhatHappensUnlessSaid) {
  const Scenario scenario = with(
      "- {name: pile, pile: {height: 2}, at: [5, 5]}\n"
      "- {name: growing, pile: {height: [[0, 1], [9, 2]]}, at: [5, 5]}\n"
      "- {name: said, box: [1, 1, 1], at: [5, 5], class: high_dynamic}\n");
  EXPECT_EQ(scenario.objects[0].object_class, ObjectClass::kStatic);
  EXPECT_EQ(scenario.objects[1].object_class, ObjectClass::kLowDynamic);
  EXPECT_EQ(scenario.objects[2].object_class, ObjectClass::kHighDynamic);
}

TEST_F(ScenarioTest, ABoxStandsInTheGroundUnlessLifted) {
  const Scenario scenario = with(
      "- {name: standing, box: [3, 2, 1], at: [5, 5]}\n"
      "- {name: lifted, box: [3, 2, 1], at: [5, 5], lift: 2}\n");
  const BodyBox standing = std::get<Body>(scenario.objects[0].run->shape).front();
  EXPECT_TRUE(standing.size.isApprox(Eigen::Vector3d(3, 2, 1.4)));
  EXPECT_NEAR(standing.T_body_box.translation.z(), 0.3, 1e-12);
  const BodyBox lifted = std::get<Body>(scenario.objects[1].run->shape).front();
  EXPECT_TRUE(lifted.size.isApprox(Eigen::Vector3d(3, 2, 1)));
  EXPECT_EQ(scenario.objects[1].run->lift, 2);
}

TEST_F(ScenarioTest, BodiesOfTheTextJoinTheBuiltInOnes) {
  const Scenario scenario =
      read("bodies:\n  cube: [{size: [1, 1, 1], at: [0, 0, 2]}]\n" + kEmptyWorld +
           "- {name: cube, body: cube, at: [5, 5]}\n"
           "- {name: truck, body: truck, at: [5, 9]}\n"
           "- {name: table, body: [{size: [1, 1, 0.1], at: [0, 0, 1]}], at: [5, -9]}\n");
  EXPECT_NEAR(std::get<Body>(scenario.objects[0].run->shape).front().T_body_box.translation.z(), 2.5, 1e-12);
  EXPECT_GT(std::get<Body>(scenario.objects[1].run->shape).size(), 3u);
  EXPECT_EQ(std::get<Body>(scenario.objects[2].run->shape).size(), 1u);
}

TEST_F(ScenarioTest, AMeshIsLookedForBesideTheScenario) {
  make("rock.ply",
       "ply\nformat ascii 1.0\nelement vertex 3\nproperty float x\nproperty float y\nproperty float z\n"
       "element face 1\nproperty list uchar int vertex_indices\nend_header\n0 0 0\n1 0 0\n0 1 0\n3 0 1 2\n");
  const Scenario scenario = with("- {name: rock, mesh: rock.ply, at: [5, 5]}\n");
  EXPECT_EQ(std::get<TriangleMesh>(scenario.objects[0].run->shape).triangles.size(), 1u);
}

TEST(Schedule, IsLinearBetweenAndConstantOutside) {
  const Schedule height({{2, 1}, {4, 3}, {10, 0}});
  EXPECT_EQ(height.at(0), 1);
  EXPECT_EQ(height.at(3), 2);
  EXPECT_EQ(height.at(7), 1.5);
  EXPECT_EQ(height.at(11), 0);
}

TEST_F(ScenarioTest, TheExampleOfTheDocumentationReads) {
  const std::string page = content(EVERMAP_DOCS "/scenarios.md");
  const std::string fence = "```yaml\n";
  const std::size_t begin = page.find(fence);
  ASSERT_NE(begin, std::string::npos);
  const std::size_t end = page.find("```", begin + fence.size());
  const Scenario scenario = read(page.substr(begin + fence.size(), end - begin - fence.size()));
  EXPECT_GT(scenario.objects.size(), 8u);
}

TEST_F(ScenarioTest, RefusesWhatIsNoScenario) {
  EXPECT_THROW(read_scenario(path("none.yaml")), FileError);
  EXPECT_THROW(read_scenario(folder_), FileError);
  EXPECT_THROW(shipped_scenario("none"), FileError);
  EXPECT_THROW(shipped_scenario("bodies"), FileError);
  expect_refused("# no world\n", 1, "lacks scans");
  expect_refused("- 1\n- 2\n", 1, "key: value");
  expect_refused("scans: [1\n", 2, "is no YAML");
  expect_refused("scans: 1\nscans: 2\n", 2, "'scans' is set twice, first at line 1");
  expect_refused("scans: 1\n", 1, "lacks ground");
}

TEST_F(ScenarioTest, RefusesUnknownKeysEverywhere) {
  expect_refused("sand: 1\n" + kEmptyWorld, 1, "unknown key 'sand'");
  expect_refused("lidar: {beams: 1}\n" + kEmptyWorld, 1, "unknown key 'beams'");
  expect_refused(
      "scans: 1\nground:\n  area: [0, 0, 1, 1]\n  colour: red\nrobot: {sensor_height: 1, at: [0, 0]}\n", 4,
      "unknown key 'colour'");
  expect_refused("scans: 1\nground:\n  area: [0, 0, 1, 1]\n  features:\n  - lake: 1\n", 5,
                 "unknown feature lake");
  expect_object_refused("- {name: a, box: [1, 1, 1], at: [5, 5], size: 1}", "unknown key 'size'");
  expect_object_refused("- {name: a, post: {height: 1, girth: 1}, at: [5, 5]}", "unknown key 'girth'");
  expect_object_refused("- {name: a, box: [1, 1, 1], at: [5, 5], survey: {size: 1}}", "unknown key 'size'");
  expect_object_refused("- {name: a, box: [1, 1, 1], at: [5, 5], survey: {name: b}}", "cannot change name");
  expect_object_refused("- {name: a, box: [1, 1, 1], at: [5, 5], places: [[1, 1]]}", "unknown key 'at'");
  expect_object_refused("- {name: a, pile: {height: 1}, at: [5, 5], lift: 1}", "unknown key 'lift'");
}

TEST_F(ScenarioTest, RefusesImpossibleNumbers) {
  expect_refused("lidar: {channels: 0}\n" + kEmptyWorld, 1, "channels needs a whole number");
  expect_refused("lidar: {columns: 1.5}\n" + kEmptyWorld, 1, "columns needs a whole number");
  expect_refused("lidar: {elevation: [20, -20]}\n" + kEmptyWorld, 1, "elevation");
  expect_refused("lidar: {range_sigma: .nan}\n" + kEmptyWorld, 1, "not '.nan'");
  expect_refused("lidar: {max_range: .inf}\n" + kEmptyWorld, 1, "not '.inf'");
  expect_refused("lidar: {motion_distortion: 2}\n" + kEmptyWorld, 1, "true or false");
  expect_refused("seed: -1\n" + kEmptyWorld, 1, "seed");
  expect_refused("scans: 0\n", 1, "scans needs a whole number");
  expect_refused("scans: 1\nground: {area: [0, 0, 0, 5]}\n", 2, "area");
  expect_refused("scans: 1\nground: {area: [0, 0, 9000, 9000]}\n", 2, "too many squares");
  expect_object_refused("- {name: a, box: [1, -1, 1], at: [5, 5]}",
                        "box needs a number above 0, up to 1000, not '-1'");
  expect_object_refused("- {name: a, box: [1, 1], at: [5, 5]}", "box needs a list of 3 numbers");
  expect_object_refused("- {name: a, box: [1, 1, 1], at: [5]}", "at needs a list of 2 to 3 numbers");
  expect_object_refused("- {name: a, box: [1, 1, 1], at: [5, 5], reflectivity: 2}", "from 0.01 to 1");
  expect_object_refused("- {name: a, wall: {from: [1, 1], to: [1, 1], height: 1}}", "at the same place");
  expect_object_refused("- {name: a, pile: {height: [[1, 1], [0, 1]]}, at: [5, 5]}", "must increase");
  expect_object_refused("- {name: a, pile: {height: -1}, at: [5, 5]}", "at least 0");
}

TEST_F(ScenarioTest, RefusesImpossibleObjects) {
  expect_object_refused("- {name: a, at: [5, 5]}", "needs one of box");
  expect_object_refused("- {box: [1, 1, 1], at: [5, 5]}", "lacks name");
  expect_object_refused("- {name: a, box: [1, 1, 1]}", "lacks at");
  expect_object_refused("- {name: a, box: [1, 1, 1], post: {height: 1}, at: [5, 5]}", "has one of box");
  expect_object_refused("- {name: a, body: dragon, at: [5, 5]}", "there is no body dragon");
  expect_object_refused("- {name: a, box: [1, 1, 1], at: [5, 5], class: red}", "class needs one of");
  expect_object_refused("- {name: a, box: [1, 1, 1], at: [5, 5], survey: gone}", "survey needs one of");
  expect_object_refused("- {name: a, box: [1, 1, 1], at: [5, 5], survey: other}", "survey needs one of");
  expect_object_refused("- {name: a, mesh: none.ply, at: [5, 5]}", "none.ply: cannot be read: No such file");
  expect_object_refused("- {name: a, body: car, route: {speed: 1, waypoints: [[1, 1]]}}", "two waypoints");
  expect_object_refused("- {name: a, body: car, route: {speed: 0, waypoints: [[1, 1], [2, 2]]}}", "speed");
  expect_object_refused("- {name: a, pile: {height: 1}, route: {speed: 1, waypoints: [[1, 1], [2, 2]]}}",
                        "has no route");
  expect_refused(
      kEmptyWorld + "- {name: a, box: [1, 1, 1], at: [5, 5]}\n- {name: a, box: [1, 1, 1], at: [9, 5]}\n", 8,
      "an object a already, at line 7");
  expect_refused(
      "scans: 1\nground: {area: [0, 0, 9, 9]}\nrobot: {sensor_height: 1, route: {speed: 1, end: vanish,"
      " waypoints: [[1, 1], [2, 2]]}}\n",
      3, "cannot vanish");
}

TEST_F(ScenarioTest, RefusesWhatWouldTakeTheMemory) {
  expect_object_refused("- {name: a, box: [1, 1001, 1], at: [5, 5]}",
                        "box needs a number above 0, up to 1000, not '1001'");
  expect_object_refused("- {name: a, post: {height: 1e6}, at: [5, 5]}",
                        "height needs a number above 0, up to 1000");
  expect_object_refused("- {name: a, wall: {from: [0, 0], to: [1, 0], height: 1e6}}", "height needs");
  expect_object_refused("- {name: a, heap: {radius: 1e6, height: 1}, at: [5, 5]}", "radius needs");
  expect_object_refused("- {name: a, pile: {height: [[0, 1], [9, 20]], repose: 5}, at: [5, 5]}",
                        "wider than 200 m");
  std::string places;
  for (int i = 0; i < 1001; ++i) places.append("[").append(std::to_string(i)).append(", 0], ");
  expect_object_refused("- {name: a, box: [1, 1, 1], places: [" + places + "]}", "more than 1000 objects");
  std::string strip =
      "ply\nformat ascii 1.0\nelement vertex 3\nproperty int x\nproperty int y\nproperty int z\n"
      "element face 5000\nproperty list uchar int vertex_index\nend_header\n0 0 0\n1 0 0\n0 1 0\n";
  for (int i = 0; i < 5000; ++i) strip += "3 0 1 2\n";
  make("mesh.ply", strip);
  places.clear();
  for (int i = 0; i < 900; ++i) places.append("[").append(std::to_string(i)).append(", 0], ");
  expect_object_refused("- {name: a, mesh: mesh.ply, places: [" + places + "]}",
                        "its meshes have more than 4 million triangles");
}

}  // namespace
}  // namespace evermap
