// SPDX-FileCopyrightText: 2026 the evermap authors
// SPDX-License-Identifier: BSD-3-Clause
#include <chrono>
#include <thread>

#include <nlohmann/json.hpp>

#include "app/program.hpp"
#include <evermap/io/map_file.hpp>

namespace evermap {
namespace {

class InterruptionTest : public ProgramTest {
 protected:
  /// Sends `signal` once the first scan, or the one named, is done; exit code and result.
  Result interrupt(std::vector<std::string> arguments, int signal, const std::string& scan = ".bin") const {
    arguments.insert(arguments.begin(), "--verbose");  // logs every scan that is done
    const std::unique_ptr<Process> process = start(arguments);
    while (!std::filesystem::exists(path("stderr")) ||
           content(path("stderr")).find(scan) == std::string::npos) {
      std::this_thread::sleep_for(std::chrono::milliseconds(1));
    }
    process->send(signal);
    const int exit_code = process->wait();
    return {exit_code, content(path("stdout")), content(path("stderr"))};
  }

  /// Whether bytes of the new map are on their way, or have arrived.
  bool is_saving() const {
    std::error_code gone_meanwhile;
    for (const auto& entry : std::filesystem::directory_iterator(path("maps"))) {
      const std::uintmax_t size = entry.file_size(gone_meanwhile);
      if (!gone_meanwhile && size > 100'000) return true;
    }
    return false;
  }
};

TEST_F(InterruptionTest, UpdateSavesWhatItHas) {
  make_drive("before", 1, true);
  make_drive("now", 1000, false);
  expect_done(build("before", "map.evm"));
  for (const int signal : {SIGTERM, SIGINT, SIGHUP}) {
    const Result result = interrupt(update("map.evm", "now", "out.evm", {"--json"}), signal);
    ASSERT_EQ(result.exit_code, 128 + signal) << result.err;
    const auto scans = nlohmann::json::parse(result.out)["scans"];
    EXPECT_EQ(scans["interrupted"], true);
    EXPECT_GE(scans["done"], 1);
    EXPECT_LT(scans["done"], 1000);
    expect_done({"info", name("out.evm")});
  }
}

TEST_F(InterruptionTest, BuildSavesWhatItHasAndSaysSo) {
  make_drive("drive", 1000, true);
  const Result result = interrupt(build("drive", "map.evm"), SIGTERM);
  ASSERT_EQ(result.exit_code, 128 + SIGTERM) << result.err;
  EXPECT_NE(result.out.find("interrupted after "), std::string::npos) << result.out;
  EXPECT_NE(result.out.find(" of 1000 scans"), std::string::npos) << result.out;
  expect_done({"info", name("map.evm")});
}

TEST_F(InterruptionTest, AnUpdateThatWasStoppedGoesOn) {
  make_drive("before", 1, true);
  make_drive("now", 200, false);
  for (const int signal : {SIGTERM, SIGKILL}) {
    std::filesystem::remove(path("out.evm.history"));
    std::filesystem::remove(path("out.evm"));
    expect_done(build("before", "map.evm"));
    const std::vector<std::string> options = {"--json", "--sync", "1"};
    interrupt(update("map.evm", "now", "out.evm", options), signal, "10003.bin");
    std::vector<std::string> go_on = update("map.evm", "now", "out.evm", options);
    go_on.emplace_back("--resume");
    const Result result = run(go_on);
    ASSERT_EQ(result.exit_code, 0) << result.err;
    const std::size_t words = result.err.find("goes on after ");
    ASSERT_NE(words, std::string::npos) << result.err;
    const int before = std::stoi(result.err.substr(words + 14));
    EXPECT_GE(before, 1);
    EXPECT_EQ(nlohmann::json::parse(result.out)["scans"]["done"], 200 - before);
    const Result again = run(go_on);
    EXPECT_EQ(again.exit_code, 1);
    EXPECT_NE(again.err.find("was not left by such a run"), std::string::npos) << again.err;
  }
}

// As if it had never been stopped, to the bit.
TEST_F(InterruptionTest, ABuildThatWasStoppedGoesOn) {
  make_hall_drive("drive", 100);
  expect_done(build("drive", "whole.evm"));
  for (const int signal : {SIGTERM, SIGKILL}) {
    std::filesystem::remove(path("map.evm.history"));
    std::filesystem::remove(path("map.evm"));
    std::vector<std::string> arguments = build("drive", "map.evm");
    arguments.insert(arguments.end(), {"--json", "--sync", "1"});
    interrupt(arguments, signal, "10003.bin");
    arguments.emplace_back("--resume");
    const Result result = run(arguments);
    ASSERT_EQ(result.exit_code, 0) << result.err;
    EXPECT_NE(result.err.find("goes on after "), std::string::npos) << result.err;
    EXPECT_LT(nlohmann::json::parse(result.out)["scans"]["done"], 100);
    EXPECT_TRUE(content(path("map.evm")) == content(path("whole.evm")));
  }
  std::vector<std::string> again = build("drive", "whole.evm");
  again.emplace_back("--resume");
  expect_failed(again, "has no history that a run could go on with");
}

TEST_F(InterruptionTest, ALargeMapIsLeftInItsJournal) {
  Octree large(VoxelGrid{0.4});
  for (int x = -1050; x < 1050; ++x) {
    for (int y = -1050; y < 1050; ++y) {
      Leaf& leaf = large.find_or_insert(VoxelKey::from_voxel({x, y, -5}));
      leaf.covariance = {1e-2F, 0, 0, 1e-2F, 0, 1e-4F};
      leaf.count = leaf.log_odds = 3;
    }
  }
  save_map(path("map.evm"), large);
  make_drive("now", 500, false);
  const auto written = std::filesystem::last_write_time(path("map.evm"));
  const Result result = interrupt(update("map.evm", "now", "map.evm", {"--force"}), SIGTERM, "10030.bin");
  EXPECT_EQ(result.exit_code, 128 + SIGTERM) << result.err;
  EXPECT_NE(result.err.find("in its journal"), std::string::npos) << result.err;
  EXPECT_EQ(std::filesystem::last_write_time(path("map.evm")), written);
  EXPECT_EQ(run({"info", name("map.evm")}).exit_code, 0);  // puts in place what the run did
  const Result log = run({"log", name("map.evm")});
  EXPECT_NE(log.out.find(" scans"), std::string::npos) << log.out;
  EXPECT_GT(load_map(path("map.evm")).leaf_count(), large.leaf_count());
}

TEST_F(InterruptionTest, WhateverIsKilledTheVersionBeforeComesBack) {
  make_drive("before", 1, true);
  make_drive("now", 3, false);
  expect_done(build("before", "map.evm"));
  const std::string first = content(path("map.evm"));
  const std::vector<std::string> arguments = update("map.evm", "now", "map.evm", {"--sync", "1"});
  constexpr int kKills = 40;
  for (int i = 0; i < kKills; ++i) {
    const std::unique_ptr<Process> process = start(arguments);
    std::this_thread::sleep_for(std::chrono::milliseconds(2 * i));
    process->send(SIGKILL);
    process->wait();
    expect_done({"info", name("map.evm")});  // brings what was acknowledged to its end
    if (content(path("map.evm")) != first) {
      expect_done({"verify", name("map.evm")});
      expect_done({"undo", name("map.evm")});
    }
    ASSERT_TRUE(content(path("map.evm")) == first) << "killed after " << 2 * i << " ms";
    std::filesystem::remove(path("map.evm.history"));
  }
  expect_done(arguments);
  expect_done({"undo", name("map.evm")});
  ASSERT_TRUE(content(path("map.evm")) == first);
  EXPECT_FALSE(std::filesystem::exists(path("map.evm.lock")));
}

TEST_F(InterruptionTest, ASecondWriterIsRefused) {
  make_drive("before", 1, true);
  make_drive("now", 1000, false);
  expect_done(build("before", "map.evm"));
  std::vector<std::string> arguments = update("map.evm", "now", "map.evm");
  arguments.insert(arguments.begin(), "--verbose");
  const std::unique_ptr<Process> process = start(arguments);
  while (!std::filesystem::exists(path("stderr")) ||
         content(path("stderr")).find(".bin") == std::string::npos)
    std::this_thread::sleep_for(std::chrono::milliseconds(1));
  Process second(update("map.evm", "before", "map.evm"), path("stdout2"), path("stderr2"));
  EXPECT_EQ(second.wait(), 1);
  EXPECT_NE(content(path("stderr2")).find("is being changed by process"), std::string::npos)
      << content(path("stderr2"));
  process->send(SIGTERM);
  EXPECT_EQ(process->wait(), 128 + SIGTERM);
  expect_done({"info", name("map.evm")});
  expect_done(update("map.evm", "before", "map.evm"));
}

TEST_F(InterruptionTest, KilledWhileSavingTheMapIsOldOrNew) {
  std::vector<float> values;
  for (int i = 0; i < 100'000; ++i) {
    for (const int x : {i % 500 + 1, i / 500, 0, 0}) values.push_back(static_cast<float>(x));
  }
  make("cloud.bin", bytes_of(values));
  const std::vector<std::string> import = {"import", name("cloud.bin"),   "-r", "0.4",
                                           "-o",     name("maps/map.evm")};
  std::filesystem::create_directory(path("maps"));
  expect_done(import);
  const std::string new_map = content(path("maps/map.evm"));
  const std::string old_map = "the old map";

  int old_count = 0;
  int new_count = 0;
  constexpr int kKills = 100;
  for (int i = 0; i < kKills; ++i) {
    std::filesystem::remove_all(path("maps"));  // with what the killed process left behind
    std::filesystem::create_directory(path("maps"));
    make("maps/map.evm", old_map);
    const std::unique_ptr<Process> process = start(import);
    while (!is_saving()) std::this_thread::sleep_for(std::chrono::microseconds(20));
    std::this_thread::sleep_for(std::chrono::microseconds(100 * i));
    process->send(SIGKILL);
    process->wait();
    const std::string map = content(path("maps/map.evm"));
    old_count += map == old_map;
    new_count += map == new_map;
  }
  EXPECT_EQ(old_count + new_count, kKills) << old_count << " old, " << new_count << " new";
  EXPECT_GT(old_count, 0) << "no process was killed while it saved";
}

}  // namespace
}  // namespace evermap
