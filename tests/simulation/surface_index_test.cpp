// SPDX-FileCopyrightText: 2026 the evermap authors
// SPDX-License-Identifier: BSD-3-Clause
#include <cmath>
#include <numbers>
#include <random>

#include <gtest/gtest.h>

#include <evermap/simulation/surface_index.hpp>

namespace evermap {
namespace {

constexpr int kSurface = 0;

double hills(double x, double y) { return 0.3 * std::sin(x) * std::cos(0.7 * y); }

/// Hilly ground with a tilted box in it and a heap beside.
struct World {
  Scene scene;
  Pose T_map_box;
  Eigen::Vector3d box_size{2, 1.5, 1};

  World() {
    T_map_box.rotation = Eigen::AngleAxisd(0.5, Eigen::Vector3d(0.2, 0.1, 1).normalized()).toRotationMatrix();
    T_map_box.translation = {1, -1, 0.4};
    add_ground(scene, kSurface, {Eigen::Vector2d(-6, -6), Eigen::Vector2d(6, 6)}, 0.25, hills);
    add_box(scene, 1, T_map_box, box_size);
    add_heap(scene, 2, {{-2.5, 2}, 2, 1}, hills);
  }

  bool in_box(const Eigen::Vector3d& p) const {
    return ((T_map_box.inverse() * p).cwiseAbs() - 0.5 * box_size).maxCoeff() < 0;
  }
  bool below(const Eigen::Vector3d& p) const {
    const double r = (p.head<2>() - Eigen::Vector2d(-2.5, 2)).norm() / 2;
    const double heap = r < 1 ? 0.5 * (1 + std::cos(std::numbers::pi * r)) : 0;
    return p.z() < hills(p.x(), p.y()) + heap;
  }
};

TEST(SurfaceIndex, BuriedAgreesWithTheSolidsThemselves) {
  const World world;
  const SurfaceIndex index(world.scene);
  std::mt19937 generator(3);
  std::uniform_real_distribution<double> xy(-5.9, 5.9);
  std::uniform_real_distribution<double> z(-1, 2);
  int buried = 0;
  int tested = 0;
  for (int i = 0; i < 20000; ++i) {
    const Eigen::Vector3d p(xy(generator), xy(generator), z(generator));
    if (index.distance(p, 0.03) <= 0.03) continue;  // the smooth surface is not the tessellated one
    ++tested;
    buried += index.buried(p) ? 1 : 0;
    ASSERT_EQ(index.buried(p), world.in_box(p) || world.below(p)) << p.transpose();
  }
  EXPECT_GT(tested, 15000);
  EXPECT_GT(buried, 5000);
}

TEST(SurfaceIndex, DistanceAgreesWithAllTriangles) {
  const World world;
  const SurfaceIndex index(world.scene);
  std::mt19937 generator(4);
  std::uniform_real_distribution<double> coordinate(-7, 7);
  constexpr double kLimit = 1.5;
  int within = 0;
  for (int i = 0; i < 500; ++i) {
    const Eigen::Vector3d p(coordinate(generator), coordinate(generator), 0.4 * coordinate(generator));
    double expected = std::numeric_limits<double>::infinity();
    for (std::size_t t = 0; t < world.scene.triangles.size(); ++t) {
      expected = std::min(expected, (world.scene.triangle(t).closest_point(p) - p).norm());
    }
    if (expected > kLimit) expected = std::numeric_limits<double>::infinity();
    within += std::isfinite(expected) ? 1 : 0;
    ASSERT_EQ(index.distance(p, kLimit), expected) << p.transpose();
  }
  EXPECT_GT(within, 100);
  EXPECT_LT(within, 500);
}

TEST(SurfaceIndex, AnExceptedSolidBuriesNothing) {
  const World world;
  const SurfaceIndex index(world.scene);
  const Eigen::Vector3d in_box(1, -1, 0.6);
  EXPECT_TRUE(index.buried(in_box));
  EXPECT_FALSE(index.buried(in_box, 1));
}

TEST(SurfaceIndex, OfAnEmptySceneKnowsNothing) {
  const Scene scene;
  const SurfaceIndex index(scene);
  EXPECT_FALSE(index.buried({0, 0, 0}));
  EXPECT_TRUE(std::isinf(index.distance({0, 0, 0}, 10)));
}

}  // namespace
}  // namespace evermap
