// SPDX-FileCopyrightText: 2026 the evermap authors
// SPDX-License-Identifier: BSD-3-Clause
#include <algorithm>
#include <cmath>
#include <ostream>
#include <support/naive_walk.hpp>
#include <support/random_rays.hpp>
#include <vector>

#include <gtest/gtest.h>

#include <evermap/map/traversal.hpp>

namespace evermap {
namespace {

using Eigen::Vector3d;
using Eigen::Vector3i;
using test::octree_of;
using test::Random;
using test::random_scene;
using test::RayMaker;

struct Visit {
  VoxelKey key;
  double entry;  ///< [m]
  double exit;   ///< [m]
};

std::vector<Visit> traversed(const Octree& octree, const Ray& ray) {
  std::vector<Visit> visits;
  traverse(octree, ray, [&](VoxelKey key, const Leaf& leaf, double entry, double exit) {
    EXPECT_EQ(&leaf, octree.find(key));
    visits.push_back({key, entry, exit});
  });
  return visits;
}

std::vector<Visit> naively_traversed(const Octree& octree, const Ray& ray) {
  std::vector<Visit> visits;
  for (const test::NaiveStep& step : test::naive_walk(octree.grid(), ray)) {
    if (!VoxelKey::in_range(step.voxel)) continue;
    const VoxelKey key = VoxelKey::from_voxel(step.voxel);
    if (octree.find(key)) visits.push_back({key, step.entry * ray.length(), step.exit * ray.length()});
  }
  return visits;
}

void expect_equal(const Octree& octree, const Ray& ray) {
  const auto fast = traversed(octree, ray);
  const auto naive = naively_traversed(octree, ray);
  const auto same = [&](const Visit& a, const Visit& b) {
    const auto close = [](double x, double y) { return std::abs(x - y) <= 1e-9 * (std::abs(y) + 1); };
    // What a ray without length leaves, and where, is the business of its own test.
    return a.key == b.key && close(a.entry, b.entry) &&
           (ray.length() == 0 || a.exit == b.exit || close(a.exit, b.exit));
  };
  ASSERT_TRUE(std::equal(fast.begin(), fast.end(), naive.begin(), naive.end(), same))
      << fast.size() << " leaves instead of " << naive.size() << " from " << ray.origin.transpose() << " to "
      << ray.end.transpose();
}

struct GridPlace {
  double edge;        ///< [m]
  Vector3d position;  ///< [m]
};

void PrintTo(const GridPlace& place, std::ostream* out) {
  *out << "edge " << place.edge << " m at " << place.position.transpose();
}

class TraversalAt : public ::testing::TestWithParam<GridPlace> {};

TEST_P(TraversalAt, EqualsTheNaiveWalk) {
  const auto [edge, position] = GetParam();
  const VoxelGrid grid = VoxelGrid::around(position, edge);
  const Vector3i place = *grid.voxel(position);
  const Vector3d p_place = grid.origin + edge * place.cast<double>();
  Random random(17);
  std::size_t visits = 0;
  for (int scene = 0; scene < 15; ++scene) {
    RayMaker maker{random, random_scene(random)};
    const Octree octree = octree_of(grid, maker.leaves, place);
    for (int i = 0; i < 1000; ++i) {
      const Ray in_voxels = maker.make(i % RayMaker::kKinds);
      const Ray ray{p_place + edge * in_voxels.origin, p_place + edge * in_voxels.end};
      expect_equal(octree, ray);
      if (HasFatalFailure()) return;
      visits += traversed(octree, ray).size();
    }
  }
  EXPECT_GT(visits, 15000U);  // one leaf a ray: the comparison is not of nothing with nothing
}

INSTANTIATE_TEST_SUITE_P(
    Places, TraversalAt,
    ::testing::Values(GridPlace{0.25, Vector3d::Zero()}, GridPlace{0.2, Vector3d::Zero()},
                      GridPlace{0.25, Vector3d(-100, -200, -50)}, GridPlace{0.1, Vector3d(3, -7, 1)},
                      GridPlace{0.25, Vector3d(1e6, -1e6, 100)}, GridPlace{0.2, Vector3d(1e6, 1e6, 0)},
                      GridPlace{0.4, Vector3d(5e6, -4e5, 300)}, GridPlace{1, Vector3d::Zero()}));

TEST(Traversal, VeryLongRays) {
  Random random(3);
  const VoxelGrid grid{0.2};
  RayMaker maker{random, random_scene(random)};
  const Octree octree = octree_of(grid, maker.leaves);
  std::size_t visits = 0;
  for (int i = 0; i < 60; ++i) {
    const Vector3d u = random.direction();
    const Vector3d through = 0.2 * (maker.at_leaf() + 0.5 * Vector3d::Ones());
    const Ray ray{through - random.uniform(1000, 5000) * u, through + 5000 * u};
    expect_equal(octree, ray);
    visits += traversed(octree, ray).size();
  }
  EXPECT_GT(visits, 60U);
}

/// Independent of how crossings are computed: which boxes the ray cuts, and where.
TEST(Traversal, VisitsExactlyTheLeavesThatTheRayCuts) {
  Random random(5);
  const double edge = 0.2;
  std::size_t cut = 0;
  for (int scene = 0; scene < 3; ++scene) {
    RayMaker maker{random, random_scene(random)};
    const Octree octree = octree_of(VoxelGrid{edge}, maker.leaves);
    for (int i = 0; i < 500; ++i) {
      const Ray in_voxels = maker.make(i % 2 ? 13 : 7);
      const Ray ray{edge * in_voxels.origin, edge * in_voxels.end};
      auto visits = traversed(octree, ray);
      EXPECT_TRUE(std::is_sorted(visits.begin(), visits.end(),
                                 [](const Visit& a, const Visit& b) { return a.entry < b.entry; }));
      octree.for_each_leaf([&](VoxelKey key, const Leaf&) {
        const Vector3d low = edge * key.voxel().cast<double>();
        const Vector3d d = ray.end - ray.origin;
        const Vector3d t_low = (low - ray.origin).cwiseQuotient(d);
        const Vector3d t_high = (low + edge * Vector3d::Ones() - ray.origin).cwiseQuotient(d);
        const double entry = std::max(0.0, t_low.cwiseMin(t_high).maxCoeff()) * ray.length();
        const double exit = t_low.cwiseMax(t_high).minCoeff() * ray.length();
        const auto visit =
            std::find_if(visits.begin(), visits.end(), [&](const Visit& v) { return v.key == key; });
        if (visit == visits.end()) {
          EXPECT_LT(std::min(exit, ray.length()) - entry, 1e-9);
          return;
        }
        EXPECT_NEAR(visit->entry, entry, 1e-9);
        EXPECT_NEAR(visit->exit, exit, 1e-9 * (1 + exit));
        EXPECT_LE(visit->entry, ray.length() * (1 + 1e-12));
        visits.erase(visit);
        ++cut;
      });
      EXPECT_TRUE(visits.empty());
    }
  }
  EXPECT_GT(cut, 1000U);
}

/// From a dense octree in which every voxel is a leaf: single steps, one face at a time.
TEST(Traversal, VisitsNeighboursOneAfterTheOther) {
  std::vector<Vector3i> all;
  for (int i = 0; i < 20 * 20 * 20; ++i) all.emplace_back(i % 20 - 10, i / 20 % 20 - 10, i / 400 - 10);
  const Octree octree = octree_of(VoxelGrid{0.25}, all);
  Random random(6);
  for (int i = 0; i < 2000; ++i) {
    const Ray ray{random.in_cube(2.49), random.in_cube(2.49)};
    const auto visits = traversed(octree, ray);
    ASSERT_FALSE(visits.empty());
    EXPECT_EQ(visits.front().key, *octree.grid().key(ray.origin));
    EXPECT_EQ(visits.back().key, *octree.grid().key(ray.end));
    for (std::size_t k = 1; k < visits.size(); ++k) {
      EXPECT_EQ((visits[k].key.voxel() - visits[k - 1].key.voxel()).cwiseAbs().sum(), 1);
      EXPECT_EQ(visits[k].entry, visits[k - 1].exit);
    }
  }
}

TEST(Traversal, RayWithoutLengthVisitsItsOwnVoxel) {
  const Octree octree = octree_of(VoxelGrid{0.2}, {{1, 2, 3}, {1, 2, 4}});
  const Vector3d p = octree.grid().center(Vector3i(1, 2, 3));
  const auto visits = traversed(octree, {p, p});
  ASSERT_EQ(visits.size(), 1U);
  EXPECT_EQ(visits[0].key, VoxelKey::from_voxel({1, 2, 3}));
  EXPECT_EQ(visits[0].entry, 0);
  EXPECT_GE(visits[0].exit, 0);  // false for NaN
}

TEST(Traversal, RaysBeyondTheKeysVisitNothing) {
  const Octree octree = octree_of(VoxelGrid{0.2}, {{0, 0, 0}});
  const Vector3d inside(0.1, 0.1, 0.1);
  for (const Vector3d& far : {Vector3d(1e9, 0, 0), Vector3d(0, 0, 2e5), Vector3d(0, std::nan(""), 0)}) {
    EXPECT_TRUE(traversed(octree, {inside, far}).empty());
    EXPECT_TRUE(traversed(octree, {far, inside}).empty());
  }
}

/// A ray that touches the border of the range of keys must not come in again on the other side of the world.
TEST(Traversal, EndsAtTheBorderOfTheKeys) {
  const int xy = VoxelKey::kMaxXY, z = VoxelKey::kMaxZ;
  const VoxelGrid grid{0.25};
  Octree octree(grid);
  for (int x : {-xy, 0, xy - 1}) {
    for (int y : {-xy, 0, xy - 1}) {
      for (int height : {-z, 0, z - 1}) octree.find_or_insert(VoxelKey::from_voxel({x, y, height}));
    }
  }
  for (int axis = 0; axis < 3; ++axis) {
    const double border = -0.25 * (axis == 2 ? z : xy);
    Vector3d end = grid.center(Vector3i(0, 0, 0));
    end[axis] = border;
    Vector3d origin = end;
    origin[axis] += 2;
    const auto visits = traversed(octree, {origin, end});
    ASSERT_EQ(visits.size(), 1U) << "axis " << axis;
    EXPECT_EQ(visits[0].key, *grid.key(end));
  }
}

TEST(ForEachOccupied, SkipsPendingLeaves) {
  Random random(8);
  RayMaker maker{random, random_scene(random)};
  Octree octree = octree_of(VoxelGrid{0.25}, maker.leaves);
  for (const Vector3i& voxel : maker.leaves) {
    octree.find(VoxelKey::from_voxel(voxel))->log_odds = static_cast<float>(random.integer(-1, 1));
  }
  std::size_t occupied = 0, pending = 0;
  for (int i = 0; i < 2000; ++i) {
    const Ray in_voxels = maker.make(i % 2 ? 13 : 0);
    const Ray ray{0.25 * in_voxels.origin, 0.25 * in_voxels.end};
    auto expected = traversed(octree, ray);
    const std::size_t all = expected.size();
    std::erase_if(expected, [&](const Visit& v) { return !(octree.find(v.key)->log_odds > 0); });
    std::vector<Visit> found;
    for_each_occupied(octree, ray, [&](VoxelKey key, const Leaf&, double entry, double exit) {
      found.push_back({key, entry, exit});
    });
    EXPECT_TRUE(std::equal(found.begin(), found.end(), expected.begin(), expected.end(),
                           [](const Visit& a, const Visit& b) {
                             return a.key == b.key && a.entry == b.entry && a.exit == b.exit;
                           }));
    occupied += found.size();
    pending += all - found.size();
  }
  EXPECT_GT(occupied, 200U);
  EXPECT_GT(pending, 200U);
}

}  // namespace
}  // namespace evermap
