// SPDX-FileCopyrightText: 2026 the evermap authors
// SPDX-License-Identifier: BSD-3-Clause
#include <algorithm>
#include <cmath>
#include <cstdint>
#include <set>
#include <support/random_geometry.hpp>

#include <gtest/gtest.h>

#include <evermap/evaluation/observed_surface.hpp>

namespace evermap {
namespace {

using test::Random;

constexpr double kReach = 0.1;

/// As the class is described: the first end of every cube is kept for ever, and asked for every point.
class KeptEnds {
 public:
  void add(const Points& ends) {
    for (const Eigen::Vector3d& end : ends) {
      const auto key = grid_.key(end);
      if (key && cubes_.insert(key->bits()).second) ends_.push_back(end);
    }
  }
  bool observed(const Eigen::Vector3d& p) const {
    return std::any_of(ends_.begin(), ends_.end(),
                       [&](const Eigen::Vector3d& end) { return (p - end).norm() <= kReach; });
  }

 private:
  VoxelGrid grid_{kReach / 5};
  std::set<std::uint64_t> cubes_;
  Points ends_;
};

/// A floor of points, and ends scattered about it.
Points floor(double size, double spacing) {
  Points points;
  for (double x = -size / 2; x < size / 2; x += spacing) {
    for (double y = -size / 2; y < size / 2; y += spacing) points.emplace_back(x, y, 0.01 * x);
  }
  return points;
}
Points ends_near(const Points& points, std::size_t count, double sigma, Random& random) {
  Points ends;
  for (std::size_t i = 0; i < count; ++i) {
    const int at = random.integer(0, static_cast<int>(points.size()) - 1);
    ends.push_back(points[static_cast<std::size_t>(at)] + random.in_cube(sigma));
  }
  return ends;
}

TEST(ObservedSurface, IsWhatLiesNearTheEndOfARay) {
  ObservedSurface surface(kReach);
  const Points points = {{1, 0, 0}, {5, 0, 0}};
  const std::vector<std::uint32_t> index = surface.add_surface(points);
  EXPECT_EQ(surface.point(index[1]), points[1]);
  EXPECT_FALSE(surface.is_observed(index[1]));
  surface.add_ends({{5.09, 0, 0}, {1e12, 0, 0}, {NAN, 0, 0}});
  EXPECT_FALSE(surface.is_observed(index[0]));
  EXPECT_TRUE(surface.is_observed(index[1]));
  surface.add_ends({{1, 0.11, 0}});
  EXPECT_FALSE(surface.is_observed(index[0]));
  surface.add_ends({{1, -0.08, 0}});
  EXPECT_TRUE(surface.is_observed(index[0]));
}

TEST(ObservedSurface, SurfacesShareTheirPoints) {
  ObservedSurface surface(kReach);
  const auto first = surface.add_surface({{1, 0, 0}, {5, 0, 0}, {1e12, 0, 0}});
  const auto second = surface.add_surface({{5, 0, 0}, {7, 0, 0}});
  EXPECT_EQ(second[0], first[1]);
  EXPECT_EQ(second[1], 3U);
  surface.add_ends({{7, 0, 0}, {5, 0, 0}});
  EXPECT_FALSE(surface.is_observed(first[0]));
  EXPECT_TRUE(surface.is_observed(first[1]));
  EXPECT_FALSE(surface.is_observed(first[2]));
  EXPECT_TRUE(surface.is_observed(second[1]));
}

TEST(ObservedSurface, TheFirstEndOfACubeCounts) {
  ObservedSurface surface(kReach);
  const std::uint32_t index = surface.add_surface({{0, 0, 0}}).at(0);
  surface.add_ends({{0.119, 0.001, 0.001}, {0.1, 0, 0}});  // both in one cube
  EXPECT_FALSE(surface.is_observed(index));
  surface.add_ends({{0.0999, 0, 0}});
  EXPECT_TRUE(surface.is_observed(index));
}

TEST(ObservedSurface, IsWhatKeepingAllEndsWouldGive) {
  Random random(7);
  for (const double sigma : {0.02, 0.1, 0.3}) {
    const Points points = floor(4, 0.07);
    ObservedSurface surface(kReach);
    const std::vector<std::uint32_t> index = surface.add_surface(points);
    KeptEnds kept;
    std::size_t observed = 0;
    for (int scan = 0; scan < 12; ++scan) {
      const Points ends = ends_near(points, 120, sigma, random);
      surface.add_ends(ends);
      kept.add(ends);
      observed = 0;
      for (std::size_t i = 0; i < points.size(); ++i) {
        ASSERT_EQ(surface.is_observed(index[i]), kept.observed(points[i])) << points[i].transpose();
        observed += surface.is_observed(index[i]);
      }
    }
    EXPECT_GT(observed, points.size() / 10);
    EXPECT_LT(observed, points.size());
  }
}

TEST(ObservedSurface, MemoryDoesNotGrowWithTheScans) {
  Random random(8);
  const Points points = floor(6, 0.1);
  ObservedSurface surface(kReach);
  surface.add_surface(points);
  const auto drive = [&](int scans) {
    for (int i = 0; i < scans; ++i) surface.add_ends(ends_near(points, 2000, 0.05, random));
    return surface.memory_bytes();
  };
  const std::size_t early = drive(10);
  EXPECT_LE(drive(300), early);
}

}  // namespace
}  // namespace evermap
