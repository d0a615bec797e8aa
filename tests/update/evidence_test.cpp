// SPDX-FileCopyrightText: 2026 the evermap authors
// SPDX-License-Identifier: BSD-3-Clause
#include <algorithm>
#include <cmath>
#include <support/random_geometry.hpp>

#include <gtest/gtest.h>

#include <evermap/update/detail/evidence.hpp>
#include <evermap/update/detail/map_updater.hpp>

namespace evermap {
namespace {

using Eigen::Vector3d;
using Eigen::Vector3i;
using test::Random;

constexpr double kEdge = 0.5;  ///< [m]

/// Points of a level square of ground, `half_edge` [m] wide in both directions and at height `z`.
Scan ground(double half_edge, double z, double noise, int per_voxel, Random& random) {
  Scan scan;
  const int count = static_cast<int>(std::pow(2 * half_edge / kEdge, 2)) * per_voxel;
  for (int i = 0; i < count; ++i) {
    const double x = random.uniform(-half_edge, half_edge);
    const double y = random.uniform(-half_edge, half_edge);
    scan.p_sensor.emplace_back(x, y, z + noise * random.normal());
  }
  return scan;
}

BundleGrid seen(const Octree& octree, const Scan& scan) { return condense(scan, {}, octree.grid(), {}); }

TEST(AlignmentError, IsTheOffsetOfTheScanFromTheMap) {
  Random random(1);
  Octree octree(VoxelGrid{kEdge});
  add(octree, condense(ground(10, 2.25, 0.002, 50, random), {}, octree.grid(), {}), {});
  for (const double offset : {0.03, -0.08, 0.15}) {
    const Scan off = ground(10, 2.25 + offset, 0.002, 20, random);
    const double found = alignment_error(octree, seen(octree, off)).at(8);
    EXPECT_NEAR(found, 1.4826 * std::abs(offset), 0.002);
  }
  // Normally distributed offsets: their standard deviation.
  Scan wavy;
  for (int i = 0; i < 1600; ++i) {
    const Vector3d corner(kEdge * (i % 40 - 20), kEdge * (i / 40 - 20), 2.25 + 0.04 * random.normal());
    for (int k = 0; k < 4; ++k)
      wavy.p_sensor.emplace_back(corner + Vector3d(0.2 + 0.1 * (k % 2), 0.2 + 0.1 * (k / 2), 0));
  }
  EXPECT_NEAR(alignment_error(octree, seen(octree, wavy)).at(8), 0.04, 0.004);
}

TEST(AlignmentError, OfADirectionGrowsWithTheRange) {
  Random random(3);
  Octree octree(VoxelGrid{kEdge});
  add(octree, condense(ground(10, 2.25, 0.002, 50, random), {}, octree.grid(), {}), {});
  const Pose turned{Eigen::AngleAxisd(0.01, Vector3d::UnitY()).toRotationMatrix(), Vector3d::Zero()};
  const Scan scan = ground(10, 2.25, 0.002, 20, random);
  const AlignmentError found = alignment_error(octree, condense(scan, turned, octree.grid(), {}));
  EXPECT_LT(found.position, 0.03);
  EXPECT_GT(found.at(16), 1.5 * found.at(8));
}

TEST(AlignmentError, ModerateWhereTooLittleIsFlat) {
  Random random(2);
  Octree octree(VoxelGrid{kEdge});
  EXPECT_EQ(alignment_error(octree, seen(octree, {})).at(20), 0.01);
  add(octree, condense(ground(10, 2.25, 0.002, 50, random), {}, octree.grid(), {}), {});
  EXPECT_EQ(alignment_error(octree, seen(octree, ground(1, 2.35, 0.002, 20, random))).at(20),
            0.01);  // 16 voxels
  // Too few points a bundle to know better than the noise.
  Scan sparse;
  for (int i = 0; i < 1600; ++i)
    sparse.p_sensor.emplace_back(kEdge * (i % 40 - 19.5), kEdge * (i / 40 - 19.5), 2.35);
  EXPECT_EQ(alignment_error(octree, seen(octree, sparse)).at(20), 0.01);
}

/// A box's face 6 m ahead and rays through it to a wall at 12 m.
class TraceThroughAFace : public ::testing::Test {
 protected:
  TraceThroughAFace() {
    Random random(3);
    Scan face;
    for (int i = 0; i < 4000; ++i) {
      const double y = random.uniform(-0.99, 0.99);
      face.p_sensor.emplace_back(6.25 + 0.01 * random.normal(), y, random.uniform(-0.99, 0.99));
    }
    for (int i = 0; i < 4000; ++i) {
      const double y = random.uniform(-1.9, 1.9);
      beyond_.p_sensor.emplace_back(12.25, y, random.uniform(-1.9, 1.9));
    }
    add(octree_, condense(face, {}, octree_.grid(), {}), {});
  }

  Octree octree_{VoxelGrid{kEdge}};
  Scan beyond_;
};

TEST_F(TraceThroughAFace, EveryLeafIsContradictedInOrder) {
  const BundleGrid bundles = seen(octree_, beyond_);
  const Evidence evidence = trace(octree_, bundles, {});
  EXPECT_EQ(evidence.leaves.size(), octree_.leaf_count());
  std::uint32_t next = 0;
  for (const LeafEvidence& leaf : evidence.leaves) {
    EXPECT_EQ(leaf.begin, next);
    ASSERT_LT(leaf.begin, leaf.end);
    next = leaf.end;
    double none = 1, greatest = 0;
    for (std::uint32_t i = leaf.begin; i < leaf.end; ++i) {
      const Contradiction& c = evidence.contradictions[i];
      EXPECT_EQ(c.leaf, leaf.leaf);
      EXPECT_TRUE(c.impact > 0 && c.impact <= 1);
      EXPECT_TRUE(i == leaf.begin || evidence.contradictions[i - 1].bundle < c.bundle);
      none *= 1 - static_cast<double>(c.impact);
      greatest = std::max(greatest, static_cast<double>(c.impact));
    }
    EXPECT_NEAR(leaf.impact, 1 - none, 1e-12);
    EXPECT_GE(leaf.impact, greatest - 1e-12);
  }
  EXPECT_EQ(next, evidence.contradictions.size());
  EXPECT_TRUE(std::is_sorted(evidence.leaves.begin(), evidence.leaves.end(),
                             [](const LeafEvidence& a, const LeafEvidence& b) { return a.leaf < b.leaf; }));
}

TEST_F(TraceThroughAFace, HitLeavesTakeNoMiss) {
  const VoxelKey hit = *octree_.grid().key({6.25, 0.25, 0.25});
  beyond_.p_sensor.emplace_back(6.25, 0.25, 0.25);
  UpdateParameters parameters;
  parameters.spare_reobserved = false;
  const BundleGrid bundles = seen(octree_, beyond_);
  for (const LeafEvidence& leaf : trace(octree_, bundles, parameters).leaves) EXPECT_NE(leaf.leaf, hit);
  // Where the geometry is trimmed the leaf is looked at, and still takes no miss.
  parameters.trim_leaves = true;
  int found = 0;
  for (const LeafEvidence& leaf : trace(octree_, bundles, parameters).leaves) {
    if (leaf.leaf == hit) ++found;
    EXPECT_EQ(leaf.impact == 0, leaf.leaf == hit);
  }
  EXPECT_EQ(found, 1);
}

/// The face moved by 5 cm into the next voxel: near enough to be the old one when the poses are that poor.
TEST_F(TraceThroughAFace, NeighbouringHitsSpareAFaceWithinTheAlignmentError) {
  Octree octree(VoxelGrid{kEdge});
  Scan face, moved;
  for (int i = 0; i < 4000; ++i) {
    const double y = -0.99 + 1.98 * (i % 63) / 62, z = -0.99 + 1.98 * (i / 63) / 63;
    face.p_sensor.emplace_back(6.49, y, z);
    if (y < -0.51) moved.p_sensor.emplace_back(6.54, y, z);  // a quarter of it; the rest is gone
  }
  add(octree, condense(face, {}, octree.grid(), {}), {});
  moved.p_sensor.insert(moved.p_sensor.end(), beyond_.p_sensor.begin(), beyond_.p_sensor.end());
  int contradicted[2] = {0, 0};
  for (const int generous : {0, 1}) {
    UpdateParameters parameters;
    parameters.surface_tolerance = generous ? 12 : 0;  // times 1 cm, as nothing is hit that tells
    for (const LeafEvidence& leaf : trace(octree, seen(octree, moved), parameters).leaves) {
      contradicted[generous] += leaf.impact > 0;
    }
  }
  EXPECT_GT(contradicted[0], contradicted[1]);
  EXPECT_GT(contradicted[1], 0);
}

TEST_F(TraceThroughAFace, ALeafSpeaksForOneRayHoweverManyCrossIt) {
  const BundleGrid bundles = seen(octree_, beyond_);
  const auto rays = static_cast<double>(bundles.bundles().size());
  const auto leaves = static_cast<double>(octree_.leaf_count());
  ASSERT_GT(rays, leaves);
  EXPECT_NEAR(contradicting_fraction(trace(octree_, bundles, {}), bundles), leaves / rays, 1e-12);
  // All rays begin in this one.
  Octree close(VoxelGrid{kEdge});
  Scan ghost;
  Random random(4);
  for (int i = 0; i < 500; ++i)
    ghost.p_sensor.emplace_back(0.75, random.uniform(-0.3, 0.3), random.uniform(-0.3, 0.3));
  add(close, condense(ghost, {}, close.grid(), {.min_range = 0}), {});
  const Evidence evidence = trace(close, bundles, {});
  EXPECT_GT(evidence.contradictions.size(), bundles.bundles().size() / 2);
  EXPECT_LE(contradicting_fraction(evidence, bundles), static_cast<double>(close.leaf_count()) / rays);
}

/// Rays to a wall 12 m ahead, whose ends are between these heights [m], and what they say against the map.
double impact_of_rays_to_heights(const Octree& octree, double low, double high) {
  Random random(6);
  Scan wall;
  for (int i = 0; i < 4000; ++i) {
    const double y = random.uniform(-2, 2);
    wall.p_sensor.emplace_back(12.25, y, random.uniform(low, high));
  }
  double sum = 0;
  for (const LeafEvidence& leaf : trace(octree, seen(octree, wall), {}).leaves) sum += leaf.impact;
  return sum;
}

/// Rays graze a slab's lower face in the very leaves that hold both of its faces.
TEST(TraceBelowACeiling, RaysThatPassASlabSayNothingAgainstIt) {
  for (const int points : {2, 40}) {  // a voxel; by themselves the first make no plane, either
    Random random(5);
    Octree octree(VoxelGrid{kEdge});
    Scan slab;
    for (int i = 0; i < 144 * points; ++i) {
      const int voxel = i / points;
      const double x = 3 + kEdge * (voxel % 12 + random.uniform(0.01, 0.99));
      const double y = -3 + kEdge * (voxel / 12 + random.uniform(0.01, 0.99));
      slab.p_sensor.emplace_back(x, y, i % 2 == 0 ? 2.1 : 2.3);
    }
    add(octree, condense(slab, {}, octree.grid(), {}), {});
    EXPECT_EQ(impact_of_rays_to_heights(octree, 2.76, 2.84), 0);
    EXPECT_GT(impact_of_rays_to_heights(octree, 3.6, 4.4), 5);
  }
}

}  // namespace
}  // namespace evermap
