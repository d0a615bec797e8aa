// SPDX-FileCopyrightText: 2026 the evermap authors
// SPDX-License-Identifier: BSD-3-Clause
#include <cmath>
#include <cstring>

#include <gtest/gtest.h>
#include <rapidcheck/gtest.h>
#include <xxhash.h>

#include "files/file_fixture.hpp"
#include "support/random_octree.hpp"
#include <evermap/io/map_file.hpp>

namespace evermap {
namespace {

namespace fs = std::filesystem;

constexpr std::size_t kHeaderSize = 72;
constexpr std::size_t kBlockHeaderSize = 16;
constexpr std::size_t kRecordSize = 48;
constexpr std::size_t kFormatOffset = 8;

class MapFileTest : public FileTest {
 protected:
  /// The bytes of a saved map.
  std::string saved(const Octree& octree) {
    save_map(path("saved.evm"), octree);
    return content(path("saved.evm"));
  }
  FileError refusal(std::string_view bytes, std::string_view text) {
    const fs::path file = make("damaged.evm", bytes);
    return file_error(file, text, [&] { load_map(file); });
  }
};

Octree small_map() {
  std::mt19937 generator(1);
  return random_octree(generator, 40, VoxelGrid{0.2});
}

/// A map of one leaf, and where its record stands in the file.
Octree one_leaf() {
  Octree octree(VoxelGrid{0.2});
  Leaf& leaf = octree.find_or_insert(VoxelKey::from_voxel({1, 2, 3}));
  leaf.count = 5;
  leaf.log_odds = 1;
  return octree;
}
constexpr std::size_t kFirstRecord = kHeaderSize + kBlockHeaderSize;

void expect_equal(const Octree& a, const Octree& b) {
  EXPECT_EQ(a.grid().edge, b.grid().edge);
  EXPECT_EQ(a.grid().origin, b.grid().origin);
  EXPECT_EQ(a.leaf_count(), b.leaf_count());
  a.for_each_leaf([&](VoxelKey key, const Leaf& leaf) {
    const Leaf* other = b.find(key);
    ASSERT_NE(other, nullptr);
    EXPECT_EQ(leaf.mean_in_voxel, other->mean_in_voxel);
    EXPECT_EQ(leaf.covariance, other->covariance);
    EXPECT_EQ(leaf.count, other->count);
    EXPECT_EQ(leaf.log_odds, other->log_odds);
  });
}

template <class T>
void put(std::string& bytes, std::size_t offset, T value) {
  std::memcpy(bytes.data() + offset, &value, sizeof(value));
}

/// Makes the checksum behind `size` bytes from `begin` fit again: a forgery, or a bug of a writer.
void seal(std::string& bytes, std::size_t begin, std::size_t size) {
  put(bytes, begin + size, std::uint64_t{XXH3_64bits(bytes.data() + begin, size)});
}
void seal_header(std::string& bytes) { seal(bytes, 0, kHeaderSize - 8); }
void seal_only_block(std::string& bytes) { seal(bytes, kHeaderSize, bytes.size() - kHeaderSize - 16); }

RC_GTEST_FIXTURE_PROP(MapFileTest, ComesBackAsItWas, (unsigned seed)) {
  std::mt19937 generator(seed);
  const double edge = std::uniform_real_distribution<double>(kLeastLeafEdge, kGreatestLeafEdge)(generator);
  std::uniform_real_distribution<double> coordinate(-1e6, 1e6);
  const VoxelGrid grid =
      VoxelGrid::around({coordinate(generator), coordinate(generator), coordinate(generator)}, edge);
  const int leaves = std::uniform_int_distribution<int>(0, 2000)(generator);
  const Octree octree = random_octree(generator, leaves, grid);
  const std::string first = saved(octree);
  const Octree loaded = load_map(path("saved.evm"));
  expect_equal(octree, loaded);
  EXPECT_TRUE(saved(loaded) == first) << "saved twice, the bytes differ";
}

TEST_F(MapFileTest, AFrameComesBackAndNothingOfItMayChange) {
  Octree octree(VoxelGrid{0.2}, {"site", MapFrame::GeoPoint{48.137, -11.575, 520.5}});
  octree.find_or_insert(VoxelKey::from_voxel({1, 2, 3})).count = 5;
  const std::string bytes = saved(octree);
  EXPECT_TRUE(load_map(path("saved.evm")).frame() == octree.frame());
  save_map(path("named.evm"), Octree(VoxelGrid{0.2}, {"hall 7", {}}));
  EXPECT_EQ(load_map(path("named.evm")).frame().name, "hall 7");
  EXPECT_FALSE(load_map(path("named.evm")).frame().origin);
  for (std::size_t bit = 0; bit < 8 * bytes.size(); ++bit) {
    std::string flipped = bytes;
    flipped[bit / 8] = static_cast<char>(flipped[bit / 8] ^ (1 << bit % 8));
    refusal(flipped, "");
  }
  for (std::size_t size = 0; size < bytes.size(); ++size) refusal(bytes.substr(0, size), "");
  for (const MapFrame& bad :
       {MapFrame{"", {}}, MapFrame{std::string(256, 'x'), {}}, MapFrame{"map", MapFrame::GeoPoint{91, 0, 0}},
        MapFrame{"map", MapFrame::GeoPoint{0, 0, NAN}}})
    file_error(path("bad.evm"), "not saved", [&] { save_map(path("bad.evm"), Octree(VoxelGrid{0.2}, bad)); });
}

TEST_F(MapFileTest, TheOrderInWhichLeavesCameDoesNotShow) {
  std::vector<std::pair<VoxelKey, Leaf>> leaves;
  small_map().for_each_leaf([&](VoxelKey key, const Leaf& leaf) { leaves.emplace_back(key, leaf); });
  Octree backwards(VoxelGrid{0.2});
  std::for_each(leaves.rbegin(), leaves.rend(),
                [&](const auto& l) { backwards.find_or_insert(l.first) = l.second; });
  EXPECT_TRUE(saved(backwards) == saved(small_map()));
}

TEST_F(MapFileTest, KeysAtTheEndsOfTheRangeAreKept) {
  Octree octree(VoxelGrid{2.0});
  for (const int sign : {0, -1}) {
    const auto end = [&](int max) { return sign + max * (sign == 0 ? -1 : 1); };
    octree
        .find_or_insert(
            VoxelKey::from_voxel({end(VoxelKey::kMaxXY), end(VoxelKey::kMaxXY), end(VoxelKey::kMaxZ)}))
        .count = 1;
  }
  saved(octree);
  expect_equal(octree, load_map(path("saved.evm")));
}

TEST_F(MapFileTest, EverySingleFlippedBitIsRefused) {
  const std::string good = saved(small_map());
  for (std::size_t bit = 0; bit < 8 * good.size(); ++bit) {
    std::string bad = good;
    bad[bit / 8] = static_cast<char>(bad[bit / 8] ^ 1 << bit % 8);
    const fs::path file = make("damaged.evm", bad);
    ASSERT_THROW(load_map(file), FileError) << "bit " << bit;
  }
}

TEST_F(MapFileTest, EveryTruncationIsRefused) {
  const std::string good = saved(small_map());
  for (std::size_t size = 0; size < good.size(); ++size) {
    const fs::path file = make("damaged.evm", std::string_view(good).substr(0, size));
    ASSERT_THROW(load_map(file), FileError) << size << " bytes";
  }
}

TEST_F(MapFileTest, BytesBehindTheEndAreRefused) {
  const std::string good = saved(small_map());
  expect_at_byte(refusal(good + '\0', "1 bytes follow the map's end"), good.size());
  refusal(good + good, "bytes follow the map's end");
}

TEST_F(MapFileTest, DamageIsNamedByBlockAndByte) {
  std::string bytes = saved(one_leaf());
  bytes[kFirstRecord + 20] ^= 1;
  expect_at_byte(refusal(bytes, "block 1 of 1: its checksum does not fit"), kHeaderSize);
  const std::string small = saved(small_map());
  refusal(std::string_view(small).substr(0, small.size() - 20), "the file ends inside it");
}

TEST_F(MapFileTest, NewerFormatIsRefusedByName) {
  std::string bytes = saved(one_leaf());
  put(bytes, kFormatOffset, std::uint32_t{3});
  seal_header(bytes);
  expect_at_byte(refusal(bytes, "made by a newer evermap: format 3, this program reads up to 2"),
                 kFormatOffset);
}

TEST_F(MapFileTest, AFormatThatOnlyAFaultHasRaisedIsDamage) {
  std::string bytes = saved(one_leaf());
  put(bytes, kFormatOffset, std::uint32_t{3});
  refusal(bytes, "the map is damaged");
}

TEST_F(MapFileTest, OtherFilesAreRefused) {
  refusal("", "is empty");
  refusal("# .PCD v0.7", "is no evermap map");
  file_error(path("none.evm"), "No such file", [&] { load_map(path("none.evm")); });
  file_error(folder_, "is a folder", [&] { load_map(folder_); });
}

TEST_F(MapFileTest, ClaimsBeyondTheFileAreRefusedBeforeMemoryIsTaken) {
  std::string many_blocks = saved(one_leaf());
  put(many_blocks, 56, std::uint64_t{1} << 60);
  seal_header(many_blocks);
  refusal(many_blocks, "block 2 of 1152921504606846976: ");

  std::string many_leaves = saved(one_leaf());
  put(many_leaves, kHeaderSize + 8, VoxelKey::kVoxelsPerBlock);
  put(many_leaves, kHeaderSize + 12, std::uint32_t{VoxelKey::kVoxelsPerBlock * kRecordSize});
  refusal(many_leaves, "the file ends inside it");

  std::string more_than_voxels = saved(one_leaf());
  put(more_than_voxels, kHeaderSize + 8, std::uint32_t{80'000'000});
  put(more_than_voxels, kHeaderSize + 12, std::uint32_t{80'000'000 * kRecordSize});
  refusal(more_than_voxels, "its size makes no sense");

  std::string overflow = saved(one_leaf());  // a product that fits only modulo 2^32
  put(overflow, kHeaderSize + 8, std::uint32_t{(1U << 28) + 1});
  refusal(overflow, "its size makes no sense");
}

TEST_F(MapFileTest, LeavesMustAddUpToTheHeader) {
  std::string bytes = saved(one_leaf());
  put(bytes, 48, std::uint64_t{2});
  seal_header(bytes);
  refusal(bytes, "holds 1 leaves, the header says 2");
}

TEST_F(MapFileTest, GridsThatMakeNoSenseAreRefused) {
  for (const double edge : {0.0, -0.2, 0.049, 2.01, std::nan("")}) {
    std::string bytes = saved(one_leaf());
    put(bytes, 16, edge);
    seal_header(bytes);
    refusal(bytes, "grid makes no sense");
  }
  std::string bytes = saved(one_leaf());
  put(bytes, 24, std::numeric_limits<double>::infinity());
  seal_header(bytes);
  refusal(bytes, "grid makes no sense");
}

TEST_F(MapFileTest, LeavesThatMakeNoSenseAreRefused) {
  for (std::size_t value = 0; value < 11; ++value) {
    std::string bytes = saved(one_leaf());
    put(bytes, kFirstRecord + 4 + 4 * value, kNaN);
    seal_only_block(bytes);
    expect_at_byte(refusal(bytes, "block 1 of 1: leaf 0 makes no sense"), kFirstRecord);
  }
  std::string no_points = saved(one_leaf());
  put(no_points, kFirstRecord + 40, 0.0F);
  seal_only_block(no_points);
  refusal(no_points, "leaf 0 makes no sense");
  std::string far_key = saved(one_leaf());
  put(far_key, kFirstRecord, std::uint32_t{1} << 18);
  seal_only_block(far_key);
  refusal(far_key, "leaf 0 makes no sense");
}

TEST_F(MapFileTest, KeysMustAscend) {
  Octree octree(VoxelGrid{0.2});
  for (const int x : {0, 1}) octree.find_or_insert(VoxelKey::from_voxel({x, 0, 0})).count = 1;
  std::string twice = saved(octree);
  twice.replace(kFirstRecord + kRecordSize, 4, twice.substr(kFirstRecord, 4));
  seal_only_block(twice);
  expect_at_byte(refusal(twice, "leaf 1 makes no sense"), kFirstRecord + kRecordSize);

  // Two whole blocks, each sound in itself, in the wrong order.
  Octree far(VoxelGrid{0.2});
  for (const int x : {0, 64}) far.find_or_insert(VoxelKey::from_voxel({x, 0, 0})).count = 1;
  std::string swapped = saved(far);
  const std::size_t size = kBlockHeaderSize + kRecordSize + 8;
  std::swap_ranges(swapped.begin() + kHeaderSize, swapped.begin() + kHeaderSize + size,
                   swapped.begin() + kHeaderSize + size);
  refusal(swapped, "block 2 of 2: its key");
}

TEST_F(MapFileTest, WhatCouldNotBeLoadedIsNotSaved) {
  make("map.evm", "old");
  Octree octree = one_leaf();
  octree.find(VoxelKey::from_voxel({1, 2, 3}))->covariance[3] = kInf;
  file_error(path("map.evm"), "not saved: leaf", [&] { save_map(path("map.evm"), octree); });
  EXPECT_EQ(content(path("map.evm")), "old");
  EXPECT_EQ(files_in_folder(), 1U);
}

}  // namespace
}  // namespace evermap
