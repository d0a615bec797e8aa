// SPDX-FileCopyrightText: 2026 the evermap authors
// SPDX-License-Identifier: BSD-3-Clause
#include <chrono>
#include <csignal>
#include <sys/wait.h>
#include <thread>

#include "files/file_fixture.hpp"
#include <evermap/io/detail/atomic_file.hpp>
#include <evermap/io/detail/map_lock.hpp>

namespace evermap {
namespace {

class MapLockTest : public FileTest {
 protected:
  /// A process that holds the lock until it is killed.
  pid_t hold(const std::filesystem::path& map) const {
    const pid_t child = ::fork();
    if (child == 0) {
      const MapLock lock(map);
      std::ofstream(path("held")) << "yes";
      for (;;) ::pause();
    }
    while (!std::filesystem::exists(path("held"))) std::this_thread::sleep_for(std::chrono::milliseconds(1));
    std::filesystem::remove(path("held"));
    return child;
  }
  static void kill(pid_t child) {
    ::kill(child, SIGKILL);
    ::waitpid(child, nullptr, 0);
  }
};

TEST_F(MapLockTest, ASecondWriterIsToldWhoHoldsTheMap) {
  const pid_t child = hold(path("map.evm"));
  file_error(path("map.evm"), "is being changed by process " + std::to_string(child) + " on ",
             [&] { const MapLock lock(path("map.evm")); });
  make("map.evm", "a map");
  std::filesystem::create_symlink(path("map.evm"), path("link.evm"));
  file_error(path("link.evm"), "is being changed by process", [&] { const MapLock lock(path("link.evm")); });
  const MapLock another(path("other.evm"));
  kill(child);
  const MapLock lock(path("map.evm"));  // the dead hold nothing
}

TEST_F(MapLockTest, WhatADeadWriterLeftIsRemovedAndWhatALivingOneWritesStays) {
  const pid_t child = ::fork();
  if (child == 0) {
    AtomicFile file(path("map.evm"));
    std::ofstream(path("held")) << "yes";
    for (;;) ::pause();
  }
  while (!std::filesystem::exists(path("held"))) std::this_thread::sleep_for(std::chrono::milliseconds(1));
  std::filesystem::remove(path("held"));
  AtomicFile living(path("poses.txt"));
  living.write("1");
  EXPECT_EQ(files_in_folder(), 2U);
  { const MapLock lock(path("map.evm")); }
  EXPECT_EQ(files_in_folder(), 2U);
  kill(child);
  { const MapLock lock(path("map.evm")); }
  EXPECT_EQ(files_in_folder(), 1U);
  living.commit();
  EXPECT_EQ(content(path("poses.txt")), "1");
}

TEST_F(MapLockTest, WhoHasPatienceGetsIt) {
  const pid_t child = hold(path("map.evm"));
  std::thread killer([&] {
    std::this_thread::sleep_for(std::chrono::milliseconds(50));
    kill(child);
  });
  {
    const MapLock lock(path("map.evm"), 60);
    EXPECT_TRUE(std::filesystem::exists(path("map.evm.lock")));
  }
  killer.join();
  EXPECT_FALSE(std::filesystem::exists(path("map.evm.lock")));
}

TEST_F(MapLockTest, OnlyOneAtATimeHasIt) {
  constexpr int kProcesses = 4;
  constexpr int kTurns = 50;
  make("count", "0");
  std::vector<pid_t> children;
  for (int i = 0; i < kProcesses; ++i) {
    const pid_t child = ::fork();
    if (child == 0) {
      for (int turn = 0; turn < kTurns; ++turn) {
        const MapLock lock(path("map.evm"), 60);
        const int count = std::stoi(content(path("count")));
        make("count", std::to_string(count + 1));
      }
      ::_exit(0);
    }
    children.push_back(child);
  }
  for (const pid_t child : children) ::waitpid(child, nullptr, 0);
  EXPECT_EQ(content(path("count")), std::to_string(kProcesses * kTurns));
}

}  // namespace
}  // namespace evermap
