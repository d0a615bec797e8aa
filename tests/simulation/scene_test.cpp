// SPDX-FileCopyrightText: 2026 the evermap authors
// SPDX-License-Identifier: BSD-3-Clause
#include <cmath>
#include <map>
#include <numbers>

#include <gtest/gtest.h>

#include <evermap/simulation/scene.hpp>
#include <evermap/simulation/surface_index.hpp>

namespace evermap {
namespace {

constexpr int kGround = 0;
constexpr int kBox = 1;
constexpr int kHeapId = 2;

const Eigen::AlignedBox2d kArea(Eigen::Vector2d(-5, -5), Eigen::Vector2d(5, 5));

double level(double, double) { return 0; }
double tilted(double x, double y) { return 0.1 * x - 0.05 * y; }

Pose at(double x, double y, double z, double yaw = 0) {
  return {Eigen::AngleAxisd(yaw, Eigen::Vector3d::UnitZ()).toRotationMatrix(), Eigen::Vector3d(x, y, z)};
}

std::map<int, int> count_by_object(const std::vector<SurfaceSample>& samples) {
  std::map<int, int> count;
  for (const auto& sample : samples) ++count[sample.object];
  return count;
}

double signed_volume(const Scene& scene) {
  double volume = 0;
  for (std::size_t i = 0; i < scene.triangles.size(); ++i) {
    const Triangle3 t = scene.triangle(i);
    volume += t.a.dot(t.b.cross(t.c)) / 6;
  }
  return volume;
}

TEST(Scene, BoxFacesPointOutwards) {
  Scene scene;
  add_box(scene, kBox, at(3, -2, 1, 0.7), {2, 3, 4});
  EXPECT_NEAR(signed_volume(scene), 24, 1e-9);
}

TEST(Scene, GroundAndHeapFaceUp) {
  Scene scene;
  add_ground(scene, kGround, kArea, 0.7, tilted);
  add_heap(scene, kHeapId, {{1, 1}, 2, 1.5}, tilted);
  for (std::size_t i = 0; i < scene.triangles.size(); ++i) {
    EXPECT_GT(scene.triangle(i).scaled_normal().z(), 0);
  }
}

TEST(Scene, HeapHasItsHeightAndRadius) {
  Scene scene;
  add_heap(scene, kHeapId, {{1, 2}, 3, 1.2}, tilted);
  double rise = 0;
  double radius = 0;
  for (const auto& p : scene.vertices) {
    rise = std::max(rise, p.z() - tilted(p.x(), p.y()));
    radius = std::max(radius, (p.head<2>() - Eigen::Vector2d(1, 2)).norm());
  }
  EXPECT_NEAR(rise, 1.2, 1e-12);
  EXPECT_NEAR(radius, 3, 1e-12);
}

TEST(Scene, PileIsAsSteepAsItsReposeAndAsHighAsSaid) {
  constexpr double kRepose = 35 * std::numbers::pi / 180;
  Scene scene;
  add_pile(scene, kHeapId, {{1, 2}, 4, kRepose}, tilted);
  double top = 0;
  for (const auto& p : scene.vertices) top = std::max(top, p.z());
  EXPECT_NEAR(top, 4 + tilted(1, 2), 1e-9);
  int on_flank = 0;
  for (std::size_t i = 0; i < scene.triangles.size(); ++i) {
    const Triangle3 t = scene.triangle(i);
    ASSERT_GT(t.scaled_normal().z(), 0);
    if ((t.a.head<2>() - Eigen::Vector2d(1, 2)).norm() < 2) continue;
    ++on_flank;
    EXPECT_NEAR(std::acos(t.scaled_normal().normalized().z()), kRepose, 0.02);
  }
  EXPECT_GT(on_flank, 500);
}

TEST(Scene, PileReachesBelowTheGroundAllAround) {
  Scene scene;
  add_pile(scene, kHeapId, {{1, 2}, 2, 0.6, 0.05}, tilted);
  double radius = 0;
  for (const auto& p : scene.vertices)
    radius = std::max(radius, (p.head<2>() - Eigen::Vector2d(1, 2)).norm());
  for (const auto& p : scene.vertices) {
    if ((p.head<2>() - Eigen::Vector2d(1, 2)).norm() > radius - 1e-6) {
      EXPECT_LT(p.z(), tilted(p.x(), p.y()));
    }
  }
}

TEST(Scene, PileIsRoughWithinItsBounds) {
  const auto heights = [](double roughness) {
    Scene scene;
    add_pile(scene, kHeapId, {{1, 2}, 3, 0.6, roughness}, level);
    return scene.vertices;
  };
  const auto smooth = heights(0);
  const auto rough = heights(0.1);
  double largest = 0;
  ASSERT_EQ(smooth.size(), rough.size());
  for (std::size_t i = 0; i < smooth.size(); ++i) {
    largest = std::max(largest, std::abs(smooth[i].z() - rough[i].z()));
  }
  EXPECT_LE(largest, 0.1);
  EXPECT_GT(largest, 0.05);
}

TEST(Scene, MeshStandsWhereItIsPut) {
  const TriangleMesh mesh{{{0, 0, 0}, {1, 0, 0}, {0, 1, 0}}, {{0, 1, 2}}};
  Scene scene;
  add_box(scene, kBox, at(0, 0, 0), {1, 1, 1});
  add_mesh(scene, 7, at(3, -2, 1, std::numbers::pi / 2), mesh);
  ASSERT_EQ(scene.triangles.size(), 13u);
  EXPECT_EQ(scene.object.back(), 7);
  EXPECT_TRUE(scene.triangle(12).b.isApprox(Eigen::Vector3d(3, -1, 1)));
}

TEST(SampleSurface, HasOnePointPerSquareOfSpacingOnEveryFace) {
  Scene scene;
  add_box(scene, kBox, at(0.3, 0.2, 9, 0.4), {2, 3, 4});
  const auto samples = sample_surface(scene, 0.05);
  const double area = 2 * (2 * 3 + 3 * 4 + 4 * 2);
  EXPECT_NEAR(static_cast<double>(samples.size()), area / (0.05 * 0.05), 0.01 * area / (0.05 * 0.05));
}

TEST(SampleSurface, LeavesNoGapsOnLongFaces) {
  Scene scene;
  add_box(scene, kBox, at(0, 0, 0, 0.3), {40, 0.5, 3});
  const auto samples = sample_surface(scene, 0.1);
  const Pose T_box_map = at(0, 0, 0, 0.3).inverse();
  for (double x = -19.95; x < 20; x += 0.37) {
    double nearest = 1e9;
    for (const auto& s : samples)
      nearest = std::min(nearest, (T_box_map * s.p_map - Eigen::Vector3d(x, 0.25, 0.7)).norm());
    EXPECT_LT(nearest, 0.1) << x;
  }
}

TEST(SampleSurface, LiesOnTheSurfaces) {
  Scene scene;
  add_ground(scene, kGround, kArea, 0.5, tilted);
  add_box(scene, kBox, at(1, 1, 0.5, 0.4), {2, 2, 2});
  const SurfaceIndex index(scene);
  const auto samples = sample_surface(scene, 0.1);
  ASSERT_GT(samples.size(), 1000u);
  for (const auto& [p, object] : samples) {
    EXPECT_LT(index.distance(p, 0.1), 1e-9);
    if (object == kGround) {
      EXPECT_NEAR(p.z(), tilted(p.x(), p.y()), 1e-9);
    }
  }
}

TEST(SampleSurface, LeavesOutWhatABoxOnFlatGroundHides) {
  Scene scene;
  add_ground(scene, kGround, kArea, 0.5, level);
  add_box(scene, kBox, at(0, 0, 0.5), {2, 2, 1});  // its bottom touches the ground
  const auto count = count_by_object(sample_surface(scene, 0.1));
  EXPECT_NEAR(count.at(kGround), (100 - 4) * 100, 100);
  EXPECT_NEAR(count.at(kBox), (4 + 4 * 2) * 100, 50);
}

TEST(SampleSurface, LeavesOutGroundUnderAHeapAndKeepsTheHeap) {
  Scene scene;
  add_ground(scene, kGround, kArea, 0.5, tilted);
  add_heap(scene, kHeapId, {{0, 0}, 3, 1}, tilted);
  int heap = 0;
  for (const auto& [p, object] : sample_surface(scene, 0.1)) {
    const double r = p.head<2>().norm();
    if (object == kGround) {
      EXPECT_GT(r, 2.9);
    }
    if (object == kHeapId) ++heap;
  }
  EXPECT_GT(heap, std::numbers::pi * 9 * 100);
}

TEST(SampleSurface, KeepsGroundUnderAFloatingBox) {
  Scene scene;
  add_ground(scene, kGround, kArea, 0.5, level);
  add_box(scene, kBox, at(0, 0, 2), {2, 2, 1});
  const auto count = count_by_object(sample_surface(scene, 0.1));
  EXPECT_NEAR(count.at(kGround), 10000, 1);
  EXPECT_NEAR(count.at(kBox), (2 * 4 + 4 * 2) * 100, 50);
}

TEST(SampleSurface, IsTheSameEveryTime) {
  Scene scene;
  add_ground(scene, kGround, kArea, 0.5, tilted);
  const auto one = sample_surface(scene, 0.1);
  const auto two = sample_surface(scene, 0.1);
  ASSERT_EQ(one.size(), two.size());
  for (std::size_t i = 0; i < one.size(); ++i) EXPECT_EQ(one[i].p_map, two[i].p_map);
}

TEST(SampleSurface, OfNothingIsNothing) { EXPECT_TRUE(sample_surface(Scene{}, 0.1).empty()); }

}  // namespace
}  // namespace evermap
