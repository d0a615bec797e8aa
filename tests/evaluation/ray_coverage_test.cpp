// SPDX-FileCopyrightText: 2026 the evermap authors
// SPDX-License-Identifier: BSD-3-Clause
#include <cmath>
#include <limits>
#include <random>

#include <gtest/gtest.h>
#include <rapidcheck/gtest.h>

#include <evermap/evaluation/ray_coverage.hpp>

namespace evermap {
namespace {

/// The definition: clip every ray against every point's voxel by its three pairs of faces.
std::vector<int> rays_beyond_by_clipping(const Points& points, const VoxelGrid& grid,
                                         const std::vector<ScanRays>& scans, double margin) {
  std::vector<int> count(points.size(), 0);
  for (std::size_t i = 0; i < points.size(); ++i) {
    const Eigen::Vector3d low = grid.voxel(points[i])->cast<double>();
    for (const ScanRays& scan : scans) {
      for (const Eigen::Vector3d& end : scan.ends) {
        const double length = (end - scan.origin).norm();
        const Eigen::Vector3d o = (scan.origin - grid.origin) / grid.edge;
        const Eigen::Vector3d d = (end - scan.origin) / length;
        double entry = 0;
        double exit = std::numeric_limits<double>::infinity();
        for (int axis = 0; axis < 3; ++axis) {
          if (d[axis] == 0) {
            if (o[axis] < low[axis] || o[axis] >= low[axis] + 1) exit = -1;
            continue;
          }
          const double a = (low[axis] - o[axis]) / d[axis];
          const double b = (low[axis] + 1 - o[axis]) / d[axis];
          entry = std::max(entry, std::min(a, b));
          exit = std::min(exit, std::max(a, b));
        }
        if (entry < exit && exit < (length - margin) / grid.edge) ++count[i];
      }
    }
  }
  return count;
}

void expect_agreement(const Points& points, const VoxelGrid& grid, const std::vector<ScanRays>& scans,
                      double margin, int* total) {
  const auto counted = rays_beyond(points, grid, scans, margin);
  const auto expected = rays_beyond_by_clipping(points, grid, scans, margin);
  RC_ASSERT(counted.size() == points.size());
  for (std::size_t i = 0; i < points.size(); ++i) {
    RC_ASSERT(counted[i] == std::min(expected[i], 255));
    *total += counted[i];
  }
}

RC_GTEST_PROP(RaysBeyond, AgreeWithClippingEveryVoxel, (unsigned seed)) {
  std::mt19937 generator(seed);
  std::uniform_real_distribution<double> coordinate(-2, 2);
  const auto random_point = [&] {
    return Eigen::Vector3d(coordinate(generator), coordinate(generator), coordinate(generator));
  };
  VoxelGrid grid{0.3, {0, 0, 0}};
  if (seed % 2 == 1) grid.origin = {0.1, -0.25, 7};
  Points points(200);
  for (auto& p : points) p = grid.origin + random_point();
  std::vector<ScanRays> scans(3);
  for (auto& scan : scans) {
    scan.origin = grid.origin + random_point();
    for (int i = 0; i < 60; ++i) scan.ends.emplace_back(grid.origin + 2 * random_point());
  }
  int total = 0;
  expect_agreement(points, grid, scans, 0.45, &total);
  RC_ASSERT(total > 0);
}

// Through corners, along edges and in faces of voxels, where a walk is easily wrong.
RC_GTEST_PROP(RaysBeyond, AgreeWithClippingOnALattice, (unsigned seed)) {
  std::mt19937 generator(seed);
  std::uniform_int_distribution<int> half_steps(-8, 8);
  const auto lattice_point = [&]() -> Eigen::Vector3d {
    return Eigen::Vector3d(half_steps(generator), half_steps(generator), half_steps(generator)) / 2;
  };
  const VoxelGrid grid{1, {0, 0, 0}};
  Points points(1000);
  for (auto& p : points) p = lattice_point();
  std::vector<ScanRays> scans(2);
  std::uniform_int_distribution<int> sign(-1, 1);
  for (auto& scan : scans) {
    scan.origin = lattice_point();
    for (int i = 0; i < 30; ++i) {
      const Eigen::Vector3d step(sign(generator), sign(generator), sign(generator));
      scan.ends.emplace_back(scan.origin + 4 * step);
    }
    std::erase(scan.ends, scan.origin);
  }
  int total = 0;
  expect_agreement(points, grid, scans, 1.5, &total);
  RC_ASSERT(total > 0);
}

TEST(RaysBeyond, TheMarginBeginsAtTheFarSideOfTheVoxel) {
  const VoxelGrid grid{1, {0, 0, 0}};
  const Points points{{2.9, 0.5, 0.5}};  // voxel from 2 to 3
  const auto count = [&](double end) {
    return static_cast<int>(rays_beyond(points, grid, {{{0.5, 0.5, 0.5}, {{end, 0.5, 0.5}}}}, 1.5)[0]);
  };
  EXPECT_EQ(count(2.9), 0);
  EXPECT_EQ(count(4.4), 0);
  EXPECT_EQ(count(4.6), 1);
}

TEST(ScansBeyond, CountEachScanOnce) {
  const VoxelGrid grid{1, {0, 0, 0}};
  const ScanRays through{{0.5, 0.5, 0.5}, Points(7, {9.5, 0.5, 0.5})};
  const ScanRays beside{{0.5, 0.5, 0.5}, {{0.5, 9.5, 0.5}}};
  const Points points{{3, 0.2, 0.2}, {3, 3.2, 0.2}};
  const auto counts = scans_beyond(points, grid, {through, beside, through}, 1.5);
  EXPECT_EQ(counts, (std::vector<std::uint8_t>{2, 0}));
}

TEST(RaysBeyond, StopsCountingAt255) {
  const VoxelGrid grid{1, {0, 0, 0}};
  const ScanRays scan{{0.5, 0.5, 0.5}, Points(300, {9.5, 0.5, 0.5})};
  EXPECT_EQ(rays_beyond({{3, 0.2, 0.2}}, grid, {scan}, 1.5)[0], 255);
}

TEST(RaysBeyond, WhatHasNoKeyCountsNothing) {
  const VoxelGrid grid{1, {0, 0, 0}};
  const double nan = std::numeric_limits<double>::quiet_NaN();
  const Eigen::Vector3d o(0.5, 0.5, 0.5);
  const std::vector<ScanRays> scans{{o, {{nan, 0, 0}, {1e12, 0, 0}, o}}, {{nan, 0, 0}, {{9, 0.5, 0.5}}}};
  const auto counts = rays_beyond({{3, 0.2, 0.2}, {nan, 0, 0}}, grid, scans, 1.5);
  EXPECT_EQ(counts, (std::vector<std::uint8_t>{0, 0}));
}

TEST(Contradictable, TakesFourRays) {
  const VoxelGrid grid{1, {0, 0, 0}};
  const Points points{{2.5, 0.5, 0.5}, {2.5, 7.5, 0.5}};
  const auto scans = [](std::size_t rays) {
    return std::vector<ScanRays>{{{0.5, 0.5, 0.5}, Points(rays, {9, 0.5, 0.5})}};
  };
  EXPECT_TRUE(contradictable(points, grid, scans(3)).empty());
  EXPECT_EQ(contradictable(points, grid, scans(4)), Points{points[0]});
}

}  // namespace
}  // namespace evermap
