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
  void save(int leaves) {
    save_map(path("map.evm"), random_octree(generator_, leaves, VoxelGrid{.edge = 0.2}));
  }
  std::string map() const { return content(path("map.evm")); }

  std::mt19937 generator_{1};
};

TEST_F(MapUndoTest, BringsBackTheLastMapBitForBit) {
  save(100);
  save(200);
  const std::string second = map();
  keep_for_undo(path("map.evm"));
  save(300);
  ASSERT_NE(map(), second);
  undo_map(path("map.evm"));
  EXPECT_EQ(map(), second);
  EXPECT_EQ(files_in_folder(), 1U);
}

TEST_F(MapUndoTest, KeepsTheLastOnly) {
  save(100);
  keep_for_undo(path("map.evm"));
  save(200);
  const std::string second = map();
  keep_for_undo(path("map.evm"));
  save(300);
  undo_map(path("map.evm"));
  EXPECT_EQ(map(), second);
  EXPECT_THROW(undo_map(path("map.evm")), FileError);
  EXPECT_EQ(map(), second);
}

/// A run that ends between keeping and saving has changed nothing, and undoing it changes nothing.
TEST_F(MapUndoTest, OfARunThatDidNotSaveChangesNothing) {
  save(100);
  const std::string first = map();
  keep_for_undo(path("map.evm"));
  EXPECT_EQ(map(), first);
  undo_map(path("map.evm"));
  EXPECT_EQ(map(), first);
}

TEST_F(MapUndoTest, OfAMapThatIsNotThereKeepsNothing) {
  keep_for_undo(path("map.evm"));
  EXPECT_EQ(files_in_folder(), 0U);
  EXPECT_THROW(undo_map(path("map.evm")), FileError);
}

TEST_F(MapUndoTest, RefusesADamagedMap) {
  save(100);
  keep_for_undo(path("map.evm"));
  save(200);
  const std::string second = map();
  std::string damaged = content(undo_path(path("map.evm")));
  damaged[damaged.size() / 2] ^= 1;
  make("map.evm.undo", damaged);
  EXPECT_THROW(undo_map(path("map.evm")), FileError);
  EXPECT_EQ(map(), second);
}

TEST_F(MapUndoTest, FollowsALink) {
  save(100);
  const std::string first = map();
  std::filesystem::create_symlink(path("map.evm"), path("link.evm"));
  keep_for_undo(path("link.evm"));
  save(200);
  undo_map(path("link.evm"));
  EXPECT_EQ(map(), first);
  EXPECT_TRUE(std::filesystem::is_symlink(path("link.evm")));
}

}  // namespace
}  // namespace evermap
