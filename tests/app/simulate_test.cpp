// SPDX-FileCopyrightText: 2026 the evermap authors
// SPDX-License-Identifier: BSD-3-Clause
#include <chrono>
#include <thread>

#include "app/program.hpp"
#include <evermap/io/cloud.hpp>
#include <evermap/io/poses.hpp>

namespace evermap {
namespace {

const std::string kWorld =
    "scans: 6\n"
    "lidar: {channels: 16, columns: 256, motion_distortion: true}\n"
    "ground: {area: [-15, -15, 15, 15]}\n"
    "robot: {sensor_height: 1.5, route: {speed: 4, waypoints: [[-5, 0], [5, 0]]}}\n"
    "objects:\n"
    "- {name: box, box: [2, 2, 2], at: [0, 6]}\n"
    "- {name: come, box: [2, 2, 2], at: [6, -6], survey: absent}\n";

class SimulateTest : public ProgramTest {
 protected:
  std::vector<std::string> simulate(const std::string& world, const std::string& folder,
                                    const std::vector<std::string>& more = {}) const {
    std::vector<std::string> arguments = {"simulate", world, "-o", name(folder), "--spacing", "0.2"};
    arguments.insert(arguments.end(), more.begin(), more.end());
    return arguments;
  }
  void expect_refused(const std::string& world, const std::string& text) const {
    make("bad.yaml", world);
    expect_failed(simulate(name("bad.yaml"), "bad"), text);
    EXPECT_FALSE(std::filesystem::exists(path("bad"))) << text;
  }
  std::vector<std::string> listing(const std::string& folder) const {
    std::vector<std::string> names;
    for (const auto& entry : std::filesystem::recursive_directory_iterator(path(folder))) {
      if (entry.is_regular_file()) names.push_back(entry.path().lexically_relative(path(folder)).string());
    }
    std::sort(names.begin(), names.end());
    return names;
  }
};

TEST_F(SimulateTest, WritesWhatImportAndUpdateTake) {
  make("world.yaml", kWorld);
  expect_done(simulate(name("world.yaml"), "run", {"--truth", "2,5"}));
  EXPECT_EQ(listing("run"),
            (std::vector<std::string>{
                "poses.txt", "scans/000000.pcd", "scans/000001.pcd", "scans/000002.pcd", "scans/000003.pcd",
                "scans/000004.pcd", "scans/000005.pcd", "scenario.yaml", "survey.ply", "truth_000002.ply",
                "truth_000002_observed.ply", "truth_000005.ply", "truth_000005_observed.ply"}));
  expect_done({"import", name("run/survey.ply"), "-r", "0.4", "-o", name("map.evm")});
  expect_done({"update", name("map.evm"), name("run/scans"), "--poses", name("run/poses.txt"), "-o",
               name("after.evm")});

  const auto poses = read_poses(path("run/poses.txt")).poses;
  ASSERT_EQ(poses.size(), 6u);
  EXPECT_NEAR(poses[2].time.value(), 0.3, 1e-9);
  EXPECT_NEAR(poses[2].T_map_sensor.translation.x(), -5 + 1.2, 1e-6);
  const Scan scan = read_cloud(path("run/scans/000002.pcd"));
  EXPECT_EQ(scan.time_offset.size(), scan.p_sensor.size());
  EXPECT_GT(scan.p_sensor.size(), 1000u);
  const std::size_t all = read_cloud(path("run/truth_000005.ply")).p_sensor.size();
  const std::size_t seen = read_cloud(path("run/truth_000005_observed.ply")).p_sensor.size();
  EXPECT_LT(seen, all);
  EXPECT_GT(seen, all / 20);
}

TEST_F(SimulateTest, TheSameSeedGivesTheSameBytes) {
  make("world.yaml", kWorld);
  expect_done(simulate(name("world.yaml"), "one"));
  expect_done(simulate(name("world.yaml"), "two", {"--seed", "1", "--scans", "3"}));
  expect_done(simulate(name("world.yaml"), "three", {"--seed", "2", "--scans", "3"}));
  const auto scan = [&](const std::string& folder) { return content(path(folder + "/scans/000002.pcd")); };
  EXPECT_EQ(scan("one"), scan("two"));
  EXPECT_NE(scan("one"), scan("three"));
  EXPECT_FALSE(std::filesystem::exists(path("two/scans/000003.pcd")));
}

TEST_F(SimulateTest, KnowsTheShippedScenariosByName) {
  expect_done(simulate("yard", "run", {"--scans", "1"}));
  EXPECT_TRUE(std::filesystem::exists(path("run/truth_000000_observed.ply")));
  expect_failed(simulate("yart", "other"),
                "yart: is no shipped scenario; there are passing quarry street yard");
}

TEST_F(SimulateTest, ReplacesItsOwnFolderAndNoOther) {
  make("world.yaml", kWorld);
  expect_done(simulate(name("world.yaml"), "run"));
  expect_done(simulate(name("world.yaml"), "run", {"--scans", "2", "--truth", "0"}));
  EXPECT_EQ(listing("run"),
            (std::vector<std::string>{"poses.txt", "scans/000000.pcd", "scans/000001.pcd", "scenario.yaml",
                                      "survey.ply", "truth_000000.ply", "truth_000000_observed.ply"}));

  std::filesystem::create_directory(path("mine"));
  make("mine/scenario.yaml", kWorld);
  expect_failed(simulate(name("mine/scenario.yaml"), "mine"),
                "mine: holds files that evermap simulate did not write");
  EXPECT_EQ(content(path("mine/scenario.yaml")), kWorld);
  make("file", "x");
  expect_failed(simulate(name("world.yaml"), "file"), "is no folder");
}

TEST_F(SimulateTest, AnInterruptedRunIsNotComplete) {
  make("world.yaml", kWorld);
  expect_done(simulate(name("world.yaml"), "run"));
  const auto process = start(simulate(name("world.yaml"), "run", {"--scans", "5000"}));
  const auto patience = std::chrono::steady_clock::now() + std::chrono::seconds(20);
  while (!std::filesystem::exists(path("run/scans/000040.pcd")) &&
         std::chrono::steady_clock::now() < patience) {
    std::this_thread::sleep_for(std::chrono::milliseconds(5));
  }
  ASSERT_TRUE(std::filesystem::exists(path("run/scans/000040.pcd")));
  process->send(SIGKILL);
  EXPECT_EQ(process->wait(), -SIGKILL);
  EXPECT_FALSE(std::filesystem::exists(path("run/poses.txt")));
  expect_done(simulate(name("world.yaml"), "run"));
  EXPECT_TRUE(std::filesystem::exists(path("run/poses.txt")));
}

TEST_F(SimulateTest, RefusesBadScenariosAndWritesNothing) {
  const auto with = [](const std::string& from, const std::string& to) {
    std::string world = kWorld;
    world.replace(world.find(from), from.size(), to);
    return world;
  };
  expect_refused("scans: [", "bad.yaml: at line");
  expect_refused(with("channels: 16", "channels: 0"), "bad.yaml: at line 2: channels needs");
  expect_refused(with("speed: 4", "sped: 4"), "bad.yaml: at line 4: ");
  expect_refused(with("[[-5, 0], [5, 0]]", "[[-5, 0]]"), "bad.yaml: at line 4: a route needs at least two");
  expect_refused(with("[2, 2, 2], at: [0, 6]", "[2, .nan, 2], at: [0, 6]"), "bad.yaml: at line 6: box needs");
  expect_refused(with("box: [2, 2, 2], at: [0, 6]", "mesh: none.ply, at: [0, 6]"), "none.ply");
  expect_refused(with("at: [0, 6]", "at: [-4, 0]"), "bad.yaml: at line 6: box contains the sensor at scan");
  make("world.yaml", kWorld);
  expect_failed(simulate(name("world.yaml"), "bad", {"--truth", "6"}), "--truth 6");
  expect_failed(simulate(name("none.yaml"), "bad"), "none.yaml: cannot be read: No such file");
  EXPECT_FALSE(std::filesystem::exists(path("bad")));
}

}  // namespace
}  // namespace evermap
