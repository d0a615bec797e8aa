// SPDX-FileCopyrightText: 2026 the evermap authors
// SPDX-License-Identifier: BSD-3-Clause
#include <array>
#include <cmath>
#include <limits>
#include <set>
#include <support/random_geometry.hpp>

#include <gtest/gtest.h>

#include <evermap/geometry/voxel_key.hpp>

namespace evermap {
namespace {

using Eigen::Vector3d;
using Eigen::Vector3i;
using test::Random;

constexpr int kXY = VoxelKey::kMaxXY;
constexpr int kZ = VoxelKey::kMaxZ;

Vector3i random_voxel(Random& random) {
  const int x = random.integer(-kXY, kXY - 1);
  const int y = random.integer(-kXY, kXY - 1);
  return {x, y, random.integer(-kZ, kZ - 1)};
}

Vector3i floor_divide(const Vector3i& v, int edge) {
  return (v.cast<double>() / edge).array().floor().cast<int>();
}

TEST(VoxelKey, RoundTripsRandomVoxels) {
  Random random(1);
  for (int i = 0; i < 100000; ++i) {
    const Vector3i voxel = random_voxel(random);
    ASSERT_EQ(VoxelKey::from_voxel(voxel).voxel(), voxel);
  }
}

TEST(VoxelKey, RoundTripsTheExtremesAndTellsThemApart) {
  std::set<VoxelKey> keys;
  const std::array<int, 6> xy = {-kXY, -kXY + 1, -1, 0, 1, kXY - 1};
  const std::array<int, 6> z = {-kZ, -kZ + 1, -1, 0, 1, kZ - 1};
  for (const int x : xy) {
    for (const int y : xy) {
      for (const int height : z) {
        const Vector3i voxel(x, y, height);
        ASSERT_TRUE(VoxelKey::in_range(voxel));
        EXPECT_EQ(VoxelKey::from_voxel(voxel).voxel(), voxel);
        keys.insert(VoxelKey::from_voxel(voxel));
      }
    }
  }
  EXPECT_EQ(keys.size(), 216U);
  EXPECT_EQ(keys.begin()->bits(), 0U);
  EXPECT_EQ(keys.rbegin()->bits(), ~std::uint64_t{0});
}

TEST(VoxelKey, RangeEndsAtItsBorders) {
  EXPECT_FALSE(VoxelKey::in_range({-kXY - 1, 0, 0}));
  EXPECT_FALSE(VoxelKey::in_range({kXY, 0, 0}));
  EXPECT_FALSE(VoxelKey::in_range({0, -kXY - 1, 0}));
  EXPECT_FALSE(VoxelKey::in_range({0, kXY, 0}));
  EXPECT_FALSE(VoxelKey::in_range({0, 0, -kZ - 1}));
  EXPECT_FALSE(VoxelKey::in_range({0, 0, kZ}));
}

/// Two voxels share a block (brick) exactly when they lie in one aligned cube of 64 (8) voxels.
TEST(VoxelKey, BlocksAndBricksAreAlignedCubes) {
  Random random(2);
  int same_brick = 0, same_block = 0;
  for (int i = 0; i < 100000; ++i) {
    const Vector3i a = random_voxel(random);
    const Vector3i b = a + Vector3i(random.integer(-9, 9), random.integer(-9, 9), random.integer(-9, 9));
    if (!VoxelKey::in_range(b)) continue;
    const VoxelKey key_a = VoxelKey::from_voxel(a), key_b = VoxelKey::from_voxel(b);
    const bool block = floor_divide(a, 64) == floor_divide(b, 64);
    const bool brick = floor_divide(a, 8) == floor_divide(b, 8);
    ASSERT_EQ(key_a.block() == key_b.block(), block);
    ASSERT_EQ(key_a.block() == key_b.block() && key_a.brick_in_block() == key_b.brick_in_block(), brick);
    same_block += block;
    same_brick += brick;
  }
  EXPECT_GT(same_block, 1000);
  EXPECT_GT(same_brick, 1000);
}

TEST(VoxelKey, OrderGroupsByBlockThenBrick) {
  Random random(3);
  const auto order = [](VoxelKey key) {
    return std::array<std::uint64_t, 3>{key.block(), static_cast<std::uint64_t>(key.brick_in_block()),
                                        static_cast<std::uint64_t>(key.voxel_in_brick())};
  };
  for (int i = 0; i < 100000; ++i) {
    const Vector3i voxel = random_voxel(random) / 16;
    const VoxelKey a = VoxelKey::from_voxel(voxel);
    const VoxelKey b = VoxelKey::from_voxel(
        voxel + Vector3i(random.integer(-70, 70), random.integer(-9, 9), random.integer(-1, 1)));
    ASSERT_EQ(a < b, order(a) < order(b));
    ASSERT_EQ(a == b, order(a) == order(b));
    ASSERT_TRUE(a.brick_in_block() >= 0 && a.brick_in_block() < 512);
    ASSERT_TRUE(a.voxel_in_brick() >= 0 && a.voxel_in_brick() < 512);
  }
}

TEST(VoxelKey, IsPutTogetherFromItsParts) {
  Random random(6);
  for (int i = 0; i < 10000; ++i) {
    const VoxelKey key = VoxelKey::from_voxel(random_voxel(random));
    ASSERT_TRUE(VoxelKey::is_block(key.block()));
    const VoxelKey block = VoxelKey::first_of_block(key.block());
    const VoxelKey brick = key.first_of_brick(key.brick_in_block());
    EXPECT_EQ(block.first_of_brick(key.brick_in_block()), brick);
    EXPECT_EQ(brick.with_voxel(key.voxel_in_brick()), key);
    EXPECT_EQ(block.with_voxel_in_block(key.voxel_in_block()), key);
    const Vector3i in_block = key.voxel() - block.voxel();
    const Vector3i in_brick = key.voxel() - brick.voxel();
    EXPECT_TRUE(in_block.minCoeff() >= 0 && in_block.maxCoeff() < VoxelKey::kBlockEdge);
    EXPECT_TRUE(in_brick.minCoeff() >= 0 && in_brick.maxCoeff() < VoxelKey::kBrickEdge);
    // Whichever voxel of a brick or block is asked, the answer is the same.
    const VoxelKey other = key.with_voxel(random.integer(0, 511));
    EXPECT_EQ(other.first_of_brick(other.brick_in_block()), brick);
    EXPECT_EQ(other.with_voxel_in_block(key.voxel_in_block()), key);
  }
  EXPECT_FALSE(VoxelKey::is_block(std::uint64_t{1} << 46));
}

TEST(HashBits, SpreadsNeighbouringKeys) {
  std::set<std::uint64_t> low_bits;
  for (std::uint64_t i = 0; i < 1024; ++i) low_bits.insert(hash_bits(i << 18) & 1023);
  EXPECT_GT(low_bits.size(), 550U);  // 63 % of the slots when random; 1 when not mixed at all
}

TEST(VoxelGrid, VoxelHoldsItsPoint) {
  Random random(4);
  for (const double edge : {0.05, 0.1, 0.2, 0.25, 0.4}) {
    const VoxelGrid grid{edge};
    for (int i = 0; i < 5000; ++i) {
      const Vector3d p = random.in_cube(100);
      const auto voxel = grid.voxel(p);
      ASSERT_TRUE(voxel);
      EXPECT_LE((p - grid.center(*voxel)).cwiseAbs().maxCoeff(), edge / 2 * (1 + 1e-9));
      EXPECT_EQ(grid.key(p)->voxel(), *voxel);
      EXPECT_EQ(grid.center(*grid.key(p)), grid.center(*voxel));
    }
  }
}

TEST(VoxelGrid, LowerBordersBelongToTheVoxel) {
  const VoxelGrid grid{0.25};
  EXPECT_EQ(*grid.voxel({0, 0, 0}), Vector3i(0, 0, 0));
  EXPECT_EQ(*grid.voxel({0.25, -0.25, -0.0}), Vector3i(1, -1, 0));
  EXPECT_EQ(*grid.voxel({std::nextafter(0.25, 0), -1e-300, 0.5}), Vector3i(0, -1, 2));
}

TEST(VoxelGrid, PointsBeyondTheKeysHaveNone) {
  const VoxelGrid grid{0.25};
  const double xy = kXY * 0.25, z = kZ * 0.25;
  EXPECT_TRUE(grid.key({-xy, -xy, -z}));
  EXPECT_TRUE(grid.key({std::nextafter(xy, 0), std::nextafter(xy, 0), std::nextafter(z, 0)}));
  for (int axis = 0; axis < 3; ++axis) {
    const double border = axis < 2 ? xy : z;
    for (const double beyond : {border, std::nextafter(-border, -1e9), 1e9, -1e9, 1e300, -1e300}) {
      Vector3d p = Vector3d::Zero();
      p[axis] = beyond;
      EXPECT_FALSE(grid.key(p)) << p.transpose();
    }
  }
}

TEST(VoxelGrid, PointsThatAreNotFiniteHaveNoKey) {
  for (const double edge : {0.1, 0.25}) {
    const VoxelGrid grid{edge};
    for (const double broken :
         {std::numeric_limits<double>::quiet_NaN(), std::numeric_limits<double>::infinity(),
          -std::numeric_limits<double>::infinity()}) {
      for (int axes = 1; axes < 8; ++axes) {
        Vector3d p(1, -2, 3);
        for (int axis = 0; axis < 3; ++axis) {
          if (axes >> axis & 1) p[axis] = broken;
        }
        EXPECT_FALSE(grid.key(p)) << p.transpose();
        EXPECT_FALSE(grid.voxel(p)) << p.transpose();
      }
    }
  }
}

TEST(VoxelGrid, FarOriginKeepsVoxelsExact) {
  Random random(5);
  for (const double far : {1e6, 5e6}) {
    for (const double edge : {0.1, 0.2, 0.25}) {
      const Vector3d place(far, -far, 300);
      const VoxelGrid grid = VoxelGrid::around(place, edge);
      for (int i = 0; i < 2000; ++i) {
        const Vector3d p = place + random.in_cube(1000);
        const auto voxel = grid.voxel(p);
        ASSERT_TRUE(voxel);
        EXPECT_LE((p - grid.center(*voxel)).cwiseAbs().maxCoeff(), edge / 2 + 2e-9);
        EXPECT_EQ(*grid.voxel(grid.center(*voxel)), *voxel);
      }
    }
  }
}

TEST(VoxelGrid, OriginIsAWholeNumberOfSteps) {
  for (const double edge : {0.1, 0.2, 0.25}) {
    const double step = VoxelGrid::kOriginStep * edge;
    const VoxelGrid grid = VoxelGrid::around({5e6, -1e6, 100}, edge);
    for (int axis = 0; axis < 3; ++axis) {
      EXPECT_EQ(grid.origin[axis], std::round(grid.origin[axis] / step) * step);
    }
    EXPECT_LE((grid.origin - Vector3d(5e6, -1e6, 100)).cwiseAbs().maxCoeff(), step / 2);
    // Neighbouring places agree, and places near the map frame's origin keep it.
    EXPECT_EQ(VoxelGrid::around(grid.origin + Vector3d(500, 500, 50), edge).origin, grid.origin);
    EXPECT_EQ(VoxelGrid::around({1000, -1000, 50}, edge).origin, Vector3d::Zero());
  }
}

}  // namespace
}  // namespace evermap
