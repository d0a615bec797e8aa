// SPDX-FileCopyrightText: 2026 the evermap authors
// SPDX-License-Identifier: BSD-3-Clause
#include <random>
#include <sqlite3.h>
#include <support/random_octree.hpp>
#include <sys/wait.h>
#include <unistd.h>

#include <gtest/gtest.h>

#include "files/file_fixture.hpp"
#include <evermap/history/detail/packed_changes.hpp>
#include <evermap/history/map_history.hpp>
#include <evermap/history/map_repair.hpp>
#include <evermap/history/map_store.hpp>
#include <evermap/io/map_file.hpp>

namespace evermap {
namespace {

class MapStoreTest : public FileTest {
 protected:
  std::filesystem::path map() const { return path("map.evm"); }
  std::string bytes() const { return content(map()); }
  std::string bytes_of_version(const std::string& version) const {
    save_map(path("version.evm"), load_map_version(map().string() + "@" + version));
    return content(path("version.evm"));
  }

  /// A map, another thirtieth of which changes from call to call.
  Octree next() {
    if (octree_.empty()) octree_ = random_octree(generator_, 3000, octree_.grid());
    std::vector<VoxelKey> keys;
    octree_.for_each_leaf([&](VoxelKey key, const Leaf&) { keys.push_back(key); });
    std::uniform_int_distribution<std::size_t> any(0, keys.size() - 1);
    for (std::size_t i = 0; i < keys.size() / 30; ++i) {
      const VoxelKey key = keys[any(generator_)];
      if (i % 5 == 0) {
        octree_.erase(key);
      } else {
        octree_.find_or_insert(VoxelKey::from_voxel(key.voxel() + Eigen::Vector3i(i % 2, 0, 0))).count =
            static_cast<float>(1 + i);
      }
    }
    return octree_;
  }
  /// Saves a map as it is before evermap knows of a history, and two versions after it.
  std::vector<std::string> three_versions() {
    std::vector<std::string> versions;
    save_map(map(), next());
    versions.push_back(bytes());
    for (int i = 0; i < 2; ++i) {
      MapStore store(map());
      store.commit(next(), {"change", ""});
      versions.push_back(bytes());
    }
    return versions;
  }
  std::vector<std::string> causes() const {
    std::vector<std::string> causes;
    for (const MapVersion& version : MapHistory(map()).versions()) causes.push_back(version.cause.what);
    return causes;
  }
  /// Runs this in a process that is killed at its end, before any destructor.
  template <class Work>
  void killed_after(Work&& work) const {
    const pid_t child = ::fork();
    if (child == 0) {
      MapStore store(map());
      work(store);
      ::kill(::getpid(), SIGKILL);
    }
    int status = 0;
    ::waitpid(child, &status, 0);
    ASSERT_TRUE(WIFSIGNALED(status));
  }
  void query(const std::string& sql) const {
    sqlite3* database = nullptr;
    ASSERT_EQ(::sqlite3_open((map().string() + ".history").c_str(), &database), SQLITE_OK);
    EXPECT_EQ(::sqlite3_exec(database, sql.c_str(), nullptr, nullptr, nullptr), SQLITE_OK);
    ::sqlite3_close(database);
  }

  std::mt19937 generator_{1};
  Octree octree_{VoxelGrid{.edge = 0.2}};
};

TEST_F(MapStoreTest, EveryVersionComesBackBitForBit) {
  const std::vector<std::string> versions = three_versions();
  for (std::size_t i = 0; i < versions.size(); ++i)
    EXPECT_TRUE(bytes_of_version(std::to_string(i + 1)) == versions[i]);
  EXPECT_EQ(causes(), (std::vector<std::string>{"as it was found", "change", "change"}));
  EXPECT_TRUE(verify(map()).is_sound());
  file_error(path("map.evm.history"), "holds no version \"4\"; there are 1 to 3",
             [&] { load_map_version(map().string() + "@4"); });
}

TEST_F(MapStoreTest, ANewMapHasNoHistory) {
  MapStore(map()).commit(next(), {"build", ""});
  EXPECT_FALSE(MapHistory::exists_for(map()));
  file_error(map(), "has no history", [&] { MapHistory history(map()); });
  file_error(map(), "no version before", [&] { MapStore(map()).undo(); });
}

TEST_F(MapStoreTest, UndoOfUndoIsAsBefore) {
  const std::vector<std::string> versions = three_versions();
  MapStore store(map());
  EXPECT_EQ(store.undo(), 2);
  EXPECT_TRUE(bytes() == versions[1]);
  EXPECT_EQ(store.undo(), 3);
  EXPECT_TRUE(bytes() == versions[2]);
  EXPECT_EQ(MapHistory(map()).versions().size(), 5U);
}

TEST_F(MapStoreTest, KnowsOfAMapThatAnotherProgramPutInPlace) {
  const std::vector<std::string> versions = three_versions();
  save_map(map(), next());
  const std::string found = bytes();
  MapStore(map()).commit(next(), {"change", ""});
  EXPECT_TRUE(bytes_of_version("4") == found);
  EXPECT_EQ(causes()[3], "replaced by another program");
  EXPECT_TRUE(bytes_of_version("5") == bytes());
  MapStore(map()).undo();
  EXPECT_TRUE(bytes() == found);
}

TEST_F(MapStoreTest, AMapThatAnotherProgramPutsInPlaceDuringARunIsAVersion) {
  for (const bool has_journal : {false, true}) {
    three_versions();
    const std::size_t before = causes().size();
    MapStore store(map());
    octree_ = store.load();
    if (has_journal) {
      store.begin(octree_, {"run", ""}, {.scans = 1});
      store.acknowledge([&] { return next(); }, 1);
    }
    const Octree of_the_run = octree_;
    save_map(map(), next());
    const std::string found = bytes();
    EXPECT_FALSE(store.met_another_program());
    store.commit(of_the_run, {"run", ""});
    EXPECT_TRUE(store.met_another_program());
    ASSERT_EQ(causes().size(), before + 2);
    EXPECT_EQ(causes()[before], "replaced by another program");
    EXPECT_TRUE(bytes_of_version(std::to_string(before + 1)) == found);
    EXPECT_TRUE(fingerprint_of(load_map(map())) == fingerprint_of(of_the_run));
    EXPECT_TRUE(verify(map()).is_sound());
  }
}

TEST_F(MapStoreTest, AMapOfOtherLeavesIsAVersion) {
  three_versions();
  const std::string before = bytes();
  octree_ = Octree(VoxelGrid{.edge = 0.4});
  MapStore(map()).commit(next(), {"build", ""});
  EXPECT_TRUE(bytes_of_version("4") == bytes());
  EXPECT_TRUE(bytes_of_version("3") == before);
  EXPECT_TRUE(verify(map()).is_sound());
}

TEST_F(MapStoreTest, HoldsLittleMoreThanWhatChanged) {
  three_versions();
  const std::uintmax_t one_map = std::filesystem::file_size(map());
  for (int i = 0; i < 30; ++i) MapStore(map()).commit(next(), {"change", ""});
  EXPECT_LT(std::filesystem::file_size(path("map.evm.history")), 3 * one_map);
}

TEST_F(MapStoreTest, LeavesNothingElseBeside) {
  three_versions();
  MapHistory(map()).versions();
  EXPECT_EQ(files_in_folder(), 2U);
}

TEST_F(MapStoreTest, AKilledRunIsThereUpToTheLastScanThatItAcknowledged) {
  save_map(map(), next());
  std::vector<std::string> states = {bytes()};
  std::vector<Octree> maps = {load_map(map())};
  for (int i = 0; i < 6; ++i) {
    maps.push_back(next());
    save_map(path("state.evm"), maps.back());
    states.push_back(content(path("state.evm")));
  }
  for (const std::size_t last : {0U, 1U, 3U, 6U}) {
    std::filesystem::remove(path("map.evm.history"));
    make("map.evm", states[0]);
    killed_after([&](MapStore& store) {
      store.begin(maps[0], {"localize", ""}, {.scans = 1});
      for (std::size_t scan = 1; scan <= last; ++scan) store.acknowledge([&] { return maps[scan]; }, scan);
    });
    EXPECT_TRUE(bytes() == states[0]);
    save_map(path("read.evm"), load_map_version(map()));  // whoever comes next
    EXPECT_TRUE(content(path("read.evm")) == states[last]) << last;
    EXPECT_TRUE(bytes() == states[last]);
    if (last > 0) {
      EXPECT_EQ(causes().back(), "localize, ended by force after " + std::to_string(last) + " scans");
      EXPECT_TRUE(verify(map()).is_sound());
      MapStore store(map());
      EXPECT_EQ(store.recovered(), "");
      store.undo();
      EXPECT_TRUE(bytes() == states[0]);
    }
  }
}

TEST_F(MapStoreTest, AJournalTakesNoMoreThanAboutTheMap) {
  Octree octree = random_octree(generator_, 20000, octree_.grid());
  std::vector<VoxelKey> keys;
  octree.for_each_leaf([&](VoxelKey key, const Leaf&) { keys.push_back(key); });
  save_map(map(), octree);
  const auto size_of = [&](const char* suffix) {
    return std::filesystem::file_size(map().string() + suffix);
  };
  constexpr std::size_t kScans = 100;
  killed_after([&](MapStore& store) {
    store.begin(octree, {"serve", ""}, {.scans = 1});
    for (std::size_t scan = 1; scan <= kScans; ++scan) {
      for (const VoxelKey key : keys) octree.find(key)->count = static_cast<float>(scan);
      store.acknowledge([&] { return octree; }, scan);
    }
    save_map(path("reached.evm"), octree);
  });
  constexpr std::size_t kMiB = std::size_t{1} << 20;
  EXPECT_LT(size_of(".history"), 24 * kMiB);
  EXPECT_LT(size_of(".history-wal"), 8 * kMiB);
  save_map(path("read.evm"), load_map_version(map()));
  EXPECT_TRUE(content(path("read.evm")) == content(path("reached.evm")));
  EXPECT_EQ(causes().back(), "serve, ended by force after 100 scans");
}

TEST_F(MapStoreTest, ARunThatBeganWithAnotherMapIsThereToo) {
  const Octree start = next();
  const Octree later = next();
  save_map(path("later.evm"), later);
  killed_after([&](MapStore& store) {
    store.begin(start, {"localize", ""}, {.scans = 1});
    store.acknowledge([&] { return later; }, 1);
  });
  const MapStore store(map());
  EXPECT_NE(store.recovered(), "");
  EXPECT_TRUE(bytes() == content(path("later.evm")));
}

TEST_F(MapStoreTest, WhatWasPutInPlaceAfterAKillStaysAndTheRunIsAVersion) {
  save_map(map(), next());
  const Octree later = next();
  save_map(path("later.evm"), later);
  killed_after([&](MapStore& store) {
    store.begin(load_map(map()), {"localize", ""}, {.scans = 1});
    store.acknowledge([&] { return later; }, 1);
  });
  save_map(map(), next());
  const std::string replaced = bytes();
  { const MapStore store(map()); }
  EXPECT_TRUE(bytes() == replaced);
  EXPECT_TRUE(bytes_of_version("2") == content(path("later.evm")));
  EXPECT_TRUE(bytes_of_version("3") == replaced);
}

TEST_F(MapStoreTest, AVersionThatWasStoredIsPutInPlace) {
  three_versions();
  const std::string newest = bytes();
  query("UPDATE version SET is_in_place = 0 WHERE number = 3");
  make("map.evm", bytes_of_version("2"));
  query("UPDATE version SET is_in_place = 0 WHERE number = 3");  // reading has put it in place
  make("map.evm", "what a crash left");
  const MapStore store(map());
  EXPECT_NE(store.recovered(), "");
  EXPECT_TRUE(bytes() == newest);
}

TEST_F(MapStoreTest, ARunThatIsGivenUpLeavesNoTrace) {
  save_map(map(), next());
  const std::string before = bytes();
  {
    MapStore store(map());
    store.begin(load_map(map()), {"update", ""}, {.scans = 1});
    EXPECT_TRUE(store.acknowledge([&] { return next(); }, 1));
  }
  EXPECT_FALSE(MapHistory(map()).is_unfinished());
  EXPECT_EQ(MapStore(map()).recovered(), "");
  EXPECT_TRUE(bytes() == before);
}

TEST_F(MapStoreTest, TagsAreNamesOfVersions) {
  const std::vector<std::string> versions = three_versions();
  MapStore store(map());
  EXPECT_EQ(store.tag("spring", "2"), 2);
  EXPECT_EQ(store.tag("now"), 3);
  EXPECT_TRUE(bytes_of_version("spring") == versions[1]);
  for (const char* name : {"", "7", "two words", "a@b"})
    file_error(map(), "a tag is a word", [&] { store.tag(name); });
}

TEST_F(MapStoreTest, DropsVersionsThatNobodyKeeps) {
  const std::vector<std::string> versions = three_versions();
  for (int i = 0; i < 4; ++i) MapStore(map()).commit(next(), {"change", ""});
  const std::string newest = bytes();
  MapStore store(map());
  store.tag("spring", "2");
  EXPECT_EQ(store.prune(3600, 0), 0);
  EXPECT_EQ(store.prune(0, 0), 5);
  EXPECT_TRUE(bytes_of_version("spring") == versions[1]);
  EXPECT_TRUE(bytes_of_version("7") == newest);
  EXPECT_TRUE(verify(map()).is_sound());
  EXPECT_EQ(store.undo(), 2);
}

TEST_F(MapStoreTest, NoVersionOfAnotherMapOrPlacePasses) {
  three_versions();
  for (const char* harm :
       {"UPDATE change SET data = (SELECT data FROM change WHERE version = 1) WHERE version = 2",
        "UPDATE change SET version = 9 - version WHERE version = 2; UPDATE change SET version = 2 WHERE "
        "version = 3; UPDATE change SET version = 3 WHERE version = 7",
        "DELETE FROM change WHERE version = 2", "UPDATE version SET fingerprint = 'x' WHERE number = 2",
        "UPDATE version SET what = 'x' WHERE number = 2", "UPDATE version SET time = 7 WHERE number = 2",
        "UPDATE version SET edge = 1 WHERE number = 1"}) {
    const std::string sound = content(path("map.evm.history"));
    query(harm);
    const MapVerdict verdict = verify(map());
    EXPECT_FALSE(verdict.is_sound()) << harm;
    EXPECT_TRUE(verdict.is_map_sound);
    EXPECT_EQ(verdict.versions, 3);
    EXPECT_LT(verdict.sound_versions.size(), 3U) << harm;
    make("map.evm.history", sound);
  }
}

TEST_F(MapStoreTest, RepairsAMapFromItsHistory) {
  const std::vector<std::string> versions = three_versions();
  std::string damaged = versions[2];
  damaged[damaged.size() / 2] ^= 1;
  make("map.evm", damaged);
  EXPECT_THROW(load_map_version(map()), FileError);
  EXPECT_EQ(repair(map()).size(), 2U);
  EXPECT_TRUE(bytes() == versions[2]);
  EXPECT_TRUE(content(path("map.evm.damaged")) == damaged);
  EXPECT_TRUE(verify(map()).is_sound());
  EXPECT_TRUE(repair(map()).empty());
}

TEST_F(MapStoreTest, RepairsAHistoryFromWhatIsLeft) {
  const std::vector<std::string> versions = three_versions();
  query("UPDATE change SET data = x'00' WHERE version = 2");
  EXPECT_EQ(verify(map()).sound_versions, std::vector<int>{1});
  const std::vector<std::string> done = repair(map());
  EXPECT_EQ(done.front(), "lost versions: 2, 3");
  EXPECT_TRUE(bytes() == versions[2]);
  EXPECT_TRUE(bytes_of_version("1") == versions[0]);
  EXPECT_TRUE(bytes_of_version("2") == versions[2]);  // the map as repair found it
  EXPECT_TRUE(verify(map()).is_sound());
}

TEST_F(MapStoreTest, AHistoryThatHadHardlyBegunIsNone) {
  save_map(map(), next());
  make("map.evm.history", "");
  EXPECT_TRUE(MapHistory(map()).versions().empty());
  EXPECT_TRUE(verify(map()).is_sound());
  MapStore(map()).commit(next(), {"change", ""});
  EXPECT_EQ(MapHistory(map()).versions().size(), 2U);
}

TEST_F(MapStoreTest, AHistoryThatCannotBeReadIsSetAside) {
  const std::vector<std::string> versions = three_versions();
  make("map.evm.history", "no database");
  EXPECT_FALSE(verify(map()).is_sound());
  EXPECT_THROW(MapStore store(map()), FileError);
  repair(map());
  EXPECT_TRUE(bytes() == versions[2]);
  EXPECT_EQ(content(path("map.evm.history.damaged")), "no database");
  MapStore(map()).commit(next(), {"change", ""});
  EXPECT_TRUE(verify(map()).is_sound());
}

TEST_F(MapStoreTest, WhateverByteOfAHistoryIsDamagedNoWrongMapIsRead) {
  octree_ = random_octree(generator_, 100, octree_.grid());
  const std::vector<std::string> versions = three_versions();
  const std::string sound = content(path("map.evm.history"));
  int refused = 0;
  for (std::size_t byte = 0; byte < sound.size(); byte += 37) {
    std::string damaged = sound;
    damaged[byte] = static_cast<char>(~damaged[byte]);
    make("map.evm.history", damaged);
    for (std::size_t i = 0; i < 3; ++i) {
      try {
        save_map(path("version.evm"), MapHistory(map()).checkout(static_cast<int>(i + 1)));
        EXPECT_TRUE(content(path("version.evm")) == versions[i]) << byte;
      } catch (const FileError&) {
        ++refused;
      }
    }
    for (const char* left : {"map.evm.history-wal", "map.evm.history-shm"})
      std::filesystem::remove(path(left));
  }
  EXPECT_GT(refused, 100);
}

}  // namespace
}  // namespace evermap
