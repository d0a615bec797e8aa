// SPDX-FileCopyrightText: 2026 the evermap authors
// SPDX-License-Identifier: BSD-3-Clause
#include <chrono>
#include <cmath>
#include <map>
#include <sstream>
#include <thread>

#include <nlohmann/json.hpp>

#include "app/program.hpp"
#include <evermap/io/poses.hpp>

namespace evermap {
namespace {

using Json = nlohmann::json;

class LocalizeTest : public ProgramTest {
 protected:
  static constexpr int kScans = 12;
  LocalizeTest() { make_hall_drive("scans", kScans); }
  std::vector<std::string> localize(const std::vector<std::string>& more = {}) const {
    std::vector<std::string> arguments = {"localize", name("map.evm"), name("scans"), "-o",
                                          name("poses.txt")};
    arguments.insert(arguments.end(), more.begin(), more.end());
    return arguments;
  }
  void build_map() const {
    expect_done({"build", name("scans"), "--poses", name("scans.txt"), "-r", "0.4", "-o", name("map.evm")});
  }
  void expect_poses(const std::string& file, double tolerance) const {
    const std::vector<StampedPose> found = read_poses(path(file)).poses;
    ASSERT_EQ(found.size(), static_cast<std::size_t>(kScans));
    for (int i = 0; i < kScans; ++i) {
      const StampedPose& pose = found[static_cast<std::size_t>(i)];
      EXPECT_NEAR(pose.time.value(), 0.1 * (i + 1), 1e-6);
      EXPECT_LT((pose.T_map_sensor.translation - Eigen::Vector3d(0.1 * i, 0.02 * i, 0)).norm(), tolerance)
          << i;
    }
  }
};

TEST_F(LocalizeTest, FindsThePosesInAMap) {
  build_map();
  const Result result = run(localize({"--json"}));
  ASSERT_EQ(result.exit_code, 0) << result.err;
  const Json report = Json::parse(result.out);
  EXPECT_EQ(report["states"]["tracking"], kScans) << "the first two, too, since the motion is known";
  EXPECT_EQ(report["scans"]["done"], kScans);
  expect_poses("poses.txt", 0.03);
}

TEST_F(LocalizeTest, MaintainsTheMapTheSameForAnyNumberOfThreads) {
  build_map();
  expect_done(localize({"--maintain", "--map-out", name("one.evm"), "--threads", "1"}));
  const std::string poses = content(path("poses.txt"));
  expect_done(
      localize({"--maintain", "--map-out", name("three.evm"), "--threads", "3", "--report", name("report")}));
  EXPECT_TRUE(Json::parse(content(path("report/report.json"))).contains("leaves"));
  EXPECT_NE(content(path("report/viewer.html")).find("id=\"map-data\""), std::string::npos);
  expect_failed(localize({"--report", name("report")}), "--report tells what --maintain changes");
  EXPECT_TRUE(content(path("one.evm")) == content(path("three.evm")));
  EXPECT_EQ(content(path("poses.txt")), poses);
}

TEST_F(LocalizeTest, BuildsAMapWithoutPoses) {
  expect_done({"build", name("scans"), "-r", "0.4", "-o", name("map.evm"), "--poses-out", name("found.txt")});
  expect_poses("found.txt", 0.1);
}

TEST_F(LocalizeTest, TakesAnInitialPoseAndOdometry) {
  build_map();
  make("odometry.txt", content(path("scans.txt")));
  expect_done(localize({"--odometry", name("odometry.txt"), "--initial-pose", "0.5 0.3 0 0 0 0 1"}));
  expect_poses("poses.txt", 0.03);
}

TEST_F(LocalizeTest, OdometryMayBeTimedInNanoseconds) {
  build_map();
  std::string text;
  for (int i = 0; i < kScans; ++i) {
    text += std::to_string(i + 1) + "00000000 " + std::to_string(0.1 * i) + ' ' + std::to_string(0.02 * i) +
            " 0 0 0 0 1\n";
  }
  make("odometry.txt", text);
  const Result result = run(localize({"--odometry", name("odometry.txt")}));
  EXPECT_EQ(result.exit_code, 0) << result.err;
  EXPECT_NE(result.err.find("odometry.txt: its times were taken for nanoseconds"), std::string::npos)
      << result.err;
  expect_poses("poses.txt", 0.03);
}

TEST_F(LocalizeTest, UpdateRefusesPosesThatDoNotFitTheMapAndSaysWhy) {
  build_map();
  std::string text;  // w first
  for (int i = 0; i < kScans; ++i)
    text +=
        std::to_string(i) + ' ' + std::to_string(0.1 * i) + ' ' + std::to_string(0.02 * i) + " 0 1 0 0 0\n";
  make("poses.txt", text);
  std::vector<std::string> update = {"update", name("map.evm"), name("scans"), "--poses", name("poses.txt"),
                                     "-o",     name("new.evm")};
  expect_failed(update, "if their quaternions begin with w; write qx qy qz qw");
  EXPECT_FALSE(std::filesystem::exists(path("new.evm")));
  update.emplace_back("--force");
  expect_done(update);
}

TEST_F(LocalizeTest, OdometryThatDoesNotBelongToTheScansIsNamed) {
  build_map();
  const auto tum = [](const std::vector<double>& times) {
    std::string text;
    for (const double time : times) text += std::to_string(time) + " 0 0 0 0 0 0 1\n";
    return text;
  };
  const auto expect = [&](const std::vector<double>& times, const std::string& text) {
    make("odometry.txt", tum(times));
    expect_failed(localize({"--odometry", name("odometry.txt")}), text);
  };
  expect({0.1, 0.2, 0.3}, "has 3 poses for the 12 scans");
  expect({0.1, 0.2, 0.2, 0.4}, "line 3: the time is not later");
  expect({0.1, 0.3, 0.2, 0.4}, "line 3: the time is not later");
}

TEST_F(LocalizeTest, OdometryOfAnotherFrameIsNamed) {
  build_map();
  std::string spinning;
  for (int i = 0; i < kScans; ++i) {
    for (const double value :
         {0.1 * (i + 1), 0.0, 0.0, 0.0, 0.0, 0.0, std::sin(0.2 * i), std::cos(0.2 * i)}) {
      spinning += std::to_string(value) + " ";
    }
    spinning += '\n';
  }
  make("odometry.txt", spinning);
  expect_failed(localize({"--odometry", name("odometry.txt")}),
                "odometry.txt: hardly a scan could be tracked");
}

TEST_F(LocalizeTest, ARunCanBeUndone) {
  build_map();
  const std::string before = content(path("map.evm"));
  expect_done(localize({"--maintain", "--map-out", name("map.evm")}));
  EXPECT_FALSE(content(path("map.evm")) == before);
  expect_done({"undo", name("map.evm")});
  EXPECT_TRUE(content(path("map.evm")) == before);
}

// Poses are found to the end whether the map was there before or is made by the run.
TEST_F(LocalizeTest, ARunThatWasStoppedOrKilledGoesOn) {
  build_map();
  const std::vector<std::string> maintain =
      localize({"--maintain", "--map-out", name("kept.evm"), "--sync", "1"});
  const std::vector<std::string> odometry = {
      "build",       name("scans"),     "-r",     "0.4", "-o", name("kept.evm"),
      "--poses-out", name("poses.txt"), "--sync", "1"};
  for (const std::vector<std::string>& verb : {maintain, odometry}) {
    for (const int signal : {SIGINT, SIGKILL}) {
      for (const std::string file : {"stderr", "poses.txt", "poses.txt.part", "kept.evm", "kept.evm.history"})
        std::filesystem::remove(path(file));
      std::vector<std::string> watched = verb;
      watched.emplace_back("--verbose");
      const std::unique_ptr<Process> process = start(watched);
      for (int wait = 0; wait < 60'000; ++wait) {
        if (std::filesystem::exists(path("stderr")) &&
            content(path("stderr")).find("scan 5:") != std::string::npos)
          break;
        std::this_thread::sleep_for(std::chrono::milliseconds(1));
      }
      process->send(signal);
      process->wait();
      const bool is_part = std::filesystem::exists(path("poses.txt.part"));
      const std::size_t before = read_poses(path(is_part ? "poses.txt.part" : "poses.txt")).poses.size();
      EXPECT_GE(before, 4U);
      std::vector<std::string> resumed = verb;
      resumed.emplace_back("--resume");
      const Result result = run(resumed);
      ASSERT_EQ(result.exit_code, 0) << result.err;
      EXPECT_NE(result.err.find("goes on after " + std::to_string(before) + " poses"), std::string::npos)
          << result.err;
      EXPECT_EQ(result.err.find("not later"), std::string::npos) << result.err;
      expect_poses("poses.txt", verb == maintain ? 0.03 : 0.1);
      EXPECT_FALSE(std::filesystem::exists(path("poses.txt.part")));
      expect_done({"info", name("kept.evm")});
    }
  }
  const Result other_leaf = run({"build", name("scans"), "-r", "0.2", "-o", name("kept.evm"), "--poses-out",
                                 name("poses.txt"), "--resume"});
  EXPECT_EQ(other_leaf.exit_code, 1);
  EXPECT_NE(other_leaf.err.find("has leaves of 0.4 m"), std::string::npos) << other_leaf.err;
  std::filesystem::remove(path("poses.txt"));
  expect_failed(localize({"--resume"}), "poses.txt");
  expect_failed({"build", name("scans"), "-r", "0.4", "-o", name("kept.evm"), "--resume"}, "--poses-out");
}

TEST_F(LocalizeTest, WhatAKilledRunHadAcknowledgedIsThere) {
  build_map();
  const std::string before = content(path("map.evm"));
  std::map<int, std::string> maps, poses;  // by scans
  const std::filesystem::path scans = path("scans");
  int recovered = 0;
  for (int i = 1; i < kScans; ++i) {
    for (const std::string file : {"map.evm.history", "poses.txt", "poses.txt.part"})
      std::filesystem::remove(path(file));
    make("map.evm", before);
    const std::unique_ptr<Process> process =
        start(localize({"--maintain", "--map-out", name("map.evm"), "--sync", "1", "--verbose"}));
    const std::string taken = "scan " + std::to_string(i) + ":";
    for (int wait = 0; wait < 60'000; ++wait) {
      if (std::filesystem::exists(path("stderr")) && content(path("stderr")).find(taken) != std::string::npos)
        break;
      std::this_thread::sleep_for(std::chrono::milliseconds(1));
    }
    process->send(SIGKILL);
    process->wait();
    expect_done({"info", name("map.evm")});
    if (!std::filesystem::exists(path("map.evm.history"))) continue;
    const Json versions = Json::parse(run({"log", name("map.evm"), "--json"}).out)["versions"];
    if (versions.empty()) continue;
    const std::string cause = versions.back()["cause"];
    const std::size_t at = cause.find("ended by force after ");
    if (at == std::string::npos) continue;
    const int count = std::stoi(cause.substr(at + 21));
    if (!maps.contains(count)) {
      std::filesystem::remove_all(path("few"));
      std::filesystem::create_directory(path("few"));
      for (int scan = 0; scan < count; ++scan) {
        const std::string file = std::to_string(10000 + scan) + ".bin";
        std::filesystem::copy(scans / file, path("few") / file);
      }
      make("start.evm", before);
      run({"localize", name("start.evm"), name("few"), "-o", name("few.txt"), "--maintain", "--map-out",
           name("few.evm"), "--sync", "0"});
      maps[count] = content(path("few.evm"));
      poses[count] = content(path("few.txt"));
    }
    const bool is_part = std::filesystem::exists(path("poses.txt.part"));  // or it was killed saving the map
    EXPECT_TRUE(content(path(is_part ? "poses.txt.part" : "poses.txt")).starts_with(poses[count]))
        << "poses of the same scans";
    EXPECT_TRUE(content(path("map.evm")) == maps[count]) << cause;
    ++recovered;
  }
  EXPECT_GT(recovered, 0) << "no process was killed while it had a journal";
}

// The hall is exchanged for another one: what the first scans of it did before the robot was lost is undone.
TEST_F(LocalizeTest, TakesBackWhatALostRobotDid) {
  build_map();
  for (int i = 5; i < kScans; ++i) make("scans/" + std::to_string(10000 + i) + ".bin", hall(4, -7, 1.3));
  const Result result =
      run(localize({"--maintain", "--map-out", name("kept.evm"), "--json", "--rollback", "20"}));
  ASSERT_EQ(result.exit_code, 1) << "it is still lost at the end";
  EXPECT_NE(result.err.find("lost at the end"), std::string::npos) << result.err;
  const Json report = Json::parse(result.out);
  EXPECT_GE(report["states"]["lost"], 1);
  EXPECT_EQ(report["rolled_back"], 5);  // all that were tracked
  EXPECT_TRUE(content(path("kept.evm")) == content(path("map.evm")));
}

TEST_F(LocalizeTest, WrongUseIsNamed) {
  build_map();
  expect_failed(localize({"--maintain"}), "--map-out");
  expect_failed(localize({"--initial-pose", "0 0 0 0 0 0 3"}), "norm");
  EXPECT_EQ(run(localize({"--initial-pose", "1 2 3"})).exit_code, 2);
}

TEST_F(LocalizeTest, AnotherRateOfScansIsNoticed) {
  std::filesystem::create_directory(path("fast"));
  const std::vector<float> values = [&] {
    std::vector<float> xyzt;
    const std::string bytes = room(true);
    for (std::size_t i = 0; i + 16 <= bytes.size(); i += 16) {
      float xyz[3];
      std::memcpy(xyz, bytes.data() + i, sizeof(xyz));
      xyzt.insert(xyzt.end(),
                  {xyz[0], xyz[1], xyz[2], 0.05F * static_cast<float>(i) / static_cast<float>(bytes.size())});
    }
    return xyzt;
  }();
  const std::string points = std::to_string(values.size() / 4);
  const std::string header =
      "VERSION 0.7\nFIELDS x y z t\nSIZE 4 4 4 4\nTYPE F F F F\nCOUNT 1 1 1 1\nWIDTH " + points +
      "\nHEIGHT 1\nVIEWPOINT 0 0 0 1 0 0 0\nPOINTS " + points + "\nDATA binary\n";
  for (int i = 0; i < 3; ++i) make("fast/" + std::to_string(i) + ".pcd", header + bytes_of(values));
  const Result result = run({"build", name("fast"), "-r", "0.4", "-o", name("fast.evm")});
  EXPECT_NE(result.err.find("taken for 20 a second"), std::string::npos) << result.err;
  EXPECT_NE(result.out.find("times    field 't' (float32) in seconds, 0.05 s from first to last"),
            std::string::npos)
      << result.out;
  const Result told = run({"build", name("fast"), "-r", "0.4", "--rate", "20", "-o", name("fast.evm")});
  EXPECT_EQ(told.err.find("a second"), std::string::npos) << told.err;
}

}  // namespace
}  // namespace evermap
