// SPDX-FileCopyrightText: 2026 the evermap authors
// SPDX-License-Identifier: BSD-3-Clause
#include <cstring>
#include <random>
#include <support/random_octree.hpp>

#include <gtest/gtest.h>

#include <evermap/history/detail/packed_changes.hpp>

namespace evermap {
namespace {

std::vector<LeafChange> some_changes(int leaves) {
  std::mt19937 generator(1);
  const VoxelGrid grid{.edge = 0.2};
  return changes_between(random_octree(generator, leaves, grid), random_octree(generator, leaves, grid));
}

TEST(PackedChanges, ComeBackBitForBit) {
  for (const int leaves : {0, 1, 2, 500, 5000}) {
    const std::vector<LeafChange> changes = some_changes(leaves);
    const auto unpacked = unpack(pack(changes, 7), 7);
    ASSERT_TRUE(unpacked.has_value());
    ASSERT_EQ(unpacked->size(), changes.size());
    for (std::size_t i = 0; i < changes.size(); ++i) {
      EXPECT_EQ((*unpacked)[i].key, changes[i].key);
      EXPECT_EQ(std::memcmp(static_cast<const void*>(&(*unpacked)[i].leaf), &changes[i].leaf, sizeof(Leaf)),
                0);
    }
  }
}

TEST(PackedChanges, OfAnotherOwnerAreRefused) {
  EXPECT_FALSE(unpack(pack(some_changes(100), 7), 8).has_value());
}

TEST(PackedChanges, NoBitMayDiffer) {
  const std::string packed = pack(some_changes(20), 7);
  for (std::size_t byte = 0; byte < packed.size(); ++byte) {
    std::string damaged = packed;
    for (int bit = 0; bit < 8; ++bit) {
      damaged[byte] = static_cast<char>(packed[byte] ^ (1 << bit));
      EXPECT_FALSE(unpack(damaged, 7).has_value()) << byte << ' ' << bit;
    }
    EXPECT_FALSE(unpack(packed.substr(0, byte), 7).has_value()) << byte;
  }
}

TEST(PackedChanges, TakeLessThanLeaves) {
  const std::vector<LeafChange> changes = some_changes(5000);
  EXPECT_LT(pack(changes, 7).size(), changes.size() * sizeof(Leaf));
}

TEST(Fingerprint, TellsMapsApartWhateverTheirOrder) {
  std::mt19937 generator(1);
  const Octree octree = random_octree(generator, 500, VoxelGrid{.edge = 0.2});
  Octree other(octree.grid());
  std::vector<LeafChange> changes = changes_between(other, octree);
  std::shuffle(changes.begin(), changes.end(), generator);
  for (const LeafChange& change : changes) other.find_or_insert(change.key) = change.leaf;
  EXPECT_EQ(fingerprint_of(octree), fingerprint_of(other));
  other.find(changes.front().key)->log_odds += 1;
  EXPECT_NE(fingerprint_of(octree), fingerprint_of(other));
}

}  // namespace
}  // namespace evermap
