// SPDX-FileCopyrightText: 2026 the evermap authors
// SPDX-License-Identifier: BSD-3-Clause
#include <algorithm>
#include <compare>
#include <support/random_rays.hpp>
#include <vector>

#include <gtest/gtest.h>

#include <evermap/map/detail/ray_fan.hpp>
#include <evermap/map/traversal.hpp>

namespace evermap {
namespace {

using Eigen::Vector3d;
using Eigen::Vector3i;
using test::octree_of;
using test::Random;
using test::random_scene;
using test::RayMaker;

struct Meeting {
  std::uint32_t ray;
  VoxelKey leaf;

  friend auto operator<=>(const Meeting&, const Meeting&) = default;
};

/// Which leaves are asked whether rays meet them.
using Asked = bool (*)(VoxelKey);
bool all(VoxelKey) { return true; }
bool two_of_three(VoxelKey leaf) { return hash_bits(leaf.bits()) % 3 != 0; }

Mask512 leaves_of(const PlacedBrick& brick, Asked is_asked) {
  Mask512 leaves;
  brick.brick->for_each([&](int index, const Leaf&) {
    if (is_asked(brick.key(index))) leaves.set(index);
  });
  return leaves;
}

std::vector<Meeting> met_by_fan(const Octree& octree, const Vector3d& origin,
                                const std::vector<RayFan::Target>& targets, Asked is_asked) {
  std::vector<Meeting> meetings;
  const RayFan fan(octree.grid(), origin, targets);
  for (const PlacedBrick& brick : octree.bricks_in(fan.voxels())) {
    fan.for_each_met(brick, leaves_of(brick, is_asked),
                     [&](std::uint32_t ray, const RayFan::Target& target, VoxelKey key, const Leaf& leaf) {
                       EXPECT_EQ(&leaf, octree.find(key));
                       EXPECT_EQ(target.end_map, targets[ray].end_map);
                       meetings.push_back({ray, key});
                     });
  }
  std::sort(meetings.begin(), meetings.end());
  return meetings;
}

/// One ray after the other through the whole map.
std::vector<Meeting> met_one_by_one(const Octree& octree, const Vector3d& origin,
                                    const std::vector<RayFan::Target>& targets, Asked is_asked) {
  std::vector<Meeting> meetings;
  for (std::uint32_t i = 0; i < targets.size(); ++i) {
    const Ray ray{origin, targets[i].end_map};
    if (ray.length() == 0) continue;
    traverse(octree, ray, [&](VoxelKey key, const Leaf&, double entry, double) {
      if (is_asked(key) && entry <= targets[i].until * ray.length()) meetings.push_back({i, key});
    });
  }
  std::sort(meetings.begin(), meetings.end());
  return meetings;
}

void expect_equal(const std::vector<Meeting>& met, const std::vector<Meeting>& expected,
                  const Vector3d& origin, const std::vector<RayFan::Target>& targets) {
  const auto [got, wanted] = std::mismatch(met.begin(), met.end(), expected.begin(), expected.end());
  if (got == met.end() && wanted == expected.end()) return;
  const bool is_missing = got == met.end() || (wanted != expected.end() && *wanted < *got);
  const Meeting& wrong = is_missing ? *wanted : *got;
  const RayFan::Target& target = targets[wrong.ray];
  FAIL() << (is_missing ? "missing" : "extra") << " leaf at voxel " << wrong.leaf.voxel().transpose()
         << " on the ray from " << origin.transpose() << " to " << target.end_map.transpose() << " until "
         << target.until;
}

/// Rays of one origin: to anywhere, to corners, along axes, within planes and nearly so.
std::vector<RayFan::Target> targets_from(const Vector3d& origin, RayMaker& maker, double edge,
                                         const Vector3d& p_place) {
  std::vector<RayFan::Target> targets;
  for (int i = 0; i < 400; ++i) {
    const Ray made = maker.make(i % RayMaker::kKinds);
    const Vector3d end = maker.random.chance(0.5) ? made.end : origin + (made.end - made.origin);
    const double until = maker.random.chance(0.5) ? 1 : maker.random.uniform(-0.1, 1);
    targets.push_back({p_place + edge * end, until});
  }
  return targets;
}

struct Place {
  double edge;        ///< [m]
  Vector3d position;  ///< [m]
};

class RayFanAt : public ::testing::TestWithParam<Place> {};

TEST_P(RayFanAt, MeetsTheLeavesThatRaysMeetOneByOne) {
  const auto [edge, position] = GetParam();
  const VoxelGrid grid = VoxelGrid::around(position, edge);
  const Vector3i place = *grid.voxel(position);
  const Vector3d p_place = grid.origin + edge * place.cast<double>();
  Random random(5);
  std::size_t meetings = 0;
  for (int scene = 0; scene < 12; ++scene) {
    RayMaker maker{random, random_scene(random)};
    const Octree octree = octree_of(grid, maker.leaves, place);
    for (int fan = 0; fan < 6; ++fan) {
      const Vector3d origin = maker.make(3 * fan % RayMaker::kKinds).origin;
      const auto targets = targets_from(origin, maker, edge, p_place);
      const Vector3d origin_map = p_place + edge * origin;
      const Asked asked = fan % 2 == 0 ? all : two_of_three;
      const auto expected = met_one_by_one(octree, origin_map, targets, asked);
      expect_equal(met_by_fan(octree, origin_map, targets, asked), expected, origin_map, targets);
      if (HasFatalFailure()) return;
      meetings += expected.size();
    }
  }
  EXPECT_GT(meetings, 20000U);  // the comparison is not of nothing with nothing
}

INSTANTIATE_TEST_SUITE_P(Places, RayFanAt,
                         ::testing::Values(Place{0.25, Vector3d::Zero()},
                                           Place{0.2, Vector3d(-100, -200, -50)},
                                           Place{0.1, Vector3d(3, -7, 1)},
                                           Place{0.25, Vector3d(1e6, -1e6, 100)},
                                           Place{0.4, Vector3d(5e6, -4e5, 300)}));

TEST(RayFan, LeavesOutWhatHasNoLengthNoShareOrNoKey) {
  const VoxelGrid grid{.edge = 1};
  const Octree octree = octree_of(grid, {Vector3i(0, 0, 0), Vector3i(2, 0, 0)});
  const Vector3d origin(0.5, 0.5, 0.5);
  const Vector3d end(2.5, 0.5, 0.5);
  const std::vector<RayFan::Target> targets{
      {origin, 1}, {end, -0.1}, {Vector3d(1e9, 0.5, 0.5), 1}, {end, 0.2}, {end, 1}};
  const std::vector<Meeting> expected{{3, VoxelKey::from_voxel({0, 0, 0})},
                                      {4, VoxelKey::from_voxel({0, 0, 0})},
                                      {4, VoxelKey::from_voxel({2, 0, 0})}};
  EXPECT_EQ(met_by_fan(octree, origin, targets, all), expected);
  EXPECT_TRUE(met_by_fan(octree, Vector3d(1e9, 0, 0), targets, all).empty());
  EXPECT_TRUE(met_by_fan(octree, origin, {}, all).empty());
}

}  // namespace
}  // namespace evermap
