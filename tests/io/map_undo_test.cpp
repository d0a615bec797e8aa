// SPDX-FileCopyrightText: 2026 the evermap authors
// SPDX-License-Identifier: BSD-3-Clause
#include <random>
#include <support/random_octree.hpp>

#include <gtest/gtest.h>

#include "files/file_fixture.hpp"
#include <evermap/io/detail/map_undo.hpp>
#include <evermap/io/map_file.hpp>

namespace evermap {
namespace {

class MapUndoTest : public FileTest {
 protected:
  Octree some_map(int leaves) { return random_octree(generator_, leaves, VoxelGrid{.edge = 0.2}); }
  void save(int leaves) { save_map(path("map.evm"), some_map(leaves)); }
  void save_with_undo(int leaves) { save_map_with_undo(path("map.evm"), some_map(leaves)); }
  std::string map() const { return content(path("map.evm")); }
  /// The file that is kept beside the map.
  std::filesystem::path kept() const {
    for (const auto& entry : std::filesystem::directory_iterator(folder_)) {
      if (entry.path().string().find(".undo.") != std::string::npos) return entry.path();
    }
    return {};
  }

  std::mt19937 generator_{1};
};

TEST_F(MapUndoTest, BringsBackTheLastMapBitForBit) {
  save(100);
  save(200);
  const std::string second = map();
  save_with_undo(300);
  ASSERT_NE(map(), second);
  undo_map(path("map.evm"));
  EXPECT_EQ(map(), second);
  EXPECT_EQ(files_in_folder(), 1U);
}

TEST_F(MapUndoTest, KeepsTheLastOnly) {
  save(100);
  save_with_undo(200);
  const std::string second = map();
  save_with_undo(300);
  EXPECT_EQ(files_in_folder(), 2U);
  undo_map(path("map.evm"));
  EXPECT_EQ(map(), second);
  file_error(path("map.evm"), "no map was kept", [&] { undo_map(path("map.evm")); });
  EXPECT_EQ(map(), second);
}

TEST_F(MapUndoTest, IsRefusedForAMapThatALaterRunReplaced) {
  save(100);
  save_with_undo(200);
  save(300);
  const std::string third = map();
  file_error(path("map.evm"), "a later run replaced it", [&] { undo_map(path("map.evm")); });
  EXPECT_EQ(map(), third);
}

/// A run that ends between keeping and saving has changed nothing, and the older map is still brought back.
TEST_F(MapUndoTest, ARunThatWasKilledBeforeItSavedChangesNothing) {
  save(100);
  const std::string first = map();
  save_with_undo(200);
  std::filesystem::create_hard_link(path("map.evm"), path("map.evm.undo.pending"));
  undo_map(path("map.evm"));
  EXPECT_EQ(map(), first);
  EXPECT_EQ(files_in_folder(), 1U);
}

/// One that ends between saving and publishing what it kept is undone all the same.
TEST_F(MapUndoTest, ARunThatWasKilledAfterItSavedIsUndone) {
  for (const bool has_hard_links : {true, false}) {
    save(100);
    save_with_undo(200);
    const std::string second = map();
    if (has_hard_links) {
      std::filesystem::create_hard_link(path("map.evm"), path("map.evm.undo.pending"));
    } else {
      make("map.evm.undo.pending", second);
    }
    save(300);
    undo_map(path("map.evm"));
    EXPECT_EQ(map(), second);
    EXPECT_EQ(files_in_folder(), 1U);
  }
}

TEST_F(MapUndoTest, OfAMapThatIsNotThereKeepsNothing) {
  save_with_undo(100);
  EXPECT_EQ(files_in_folder(), 1U);
  EXPECT_THROW(undo_map(path("map.evm")), FileError);
}

TEST_F(MapUndoTest, RefusesADamagedMap) {
  save(100);
  save_with_undo(200);
  const std::string second = map();
  const std::filesystem::path file = kept();
  std::string damaged = content(file);
  damaged[damaged.size() / 2] ^= 1;
  make(file.filename().string(), damaged);
  EXPECT_THROW(undo_map(path("map.evm")), FileError);
  EXPECT_EQ(map(), second);
}

TEST_F(MapUndoTest, FollowsALink) {
  save(100);
  const std::string first = map();
  std::filesystem::create_symlink(path("map.evm"), path("link.evm"));
  save_map_with_undo(path("link.evm"), some_map(200));
  undo_map(path("link.evm"));
  EXPECT_EQ(map(), first);
  EXPECT_TRUE(std::filesystem::is_symlink(path("link.evm")));
}

}  // namespace
}  // namespace evermap
