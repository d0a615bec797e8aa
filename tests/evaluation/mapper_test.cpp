// SPDX-FileCopyrightText: 2026 the evermap authors
// SPDX-License-Identifier: BSD-3-Clause
#include <algorithm>
#include <stdexcept>
#include <support/toy_scene.hpp>

#include <gtest/gtest.h>

#include <evermap/evaluation/evermap_mapper.hpp>
#include <evermap/evaluation/mapper.hpp>

namespace evermap {
namespace {

using test::Random;
using test::ToyScene;

constexpr double kEdge = 0.2;          // [m]
constexpr double kSigma = 0.02;        // [m]
constexpr int kScans = 25;             // enough for every rule of forgetting
constexpr int kPointsOfScan = 20'000;  // some ten rays through each leaf of the box

/// Ground with a wall of 4 x 2 m across x = 9 m and, until it vanishes, a box in front of it at x = 5 m.
ToyScene scene(bool has_box) {
  ToyScene scene;
  scene.boxes.push_back({Eigen::Vector3d(9.03, -2, 0), Eigen::Vector3d(9.5, 2, 2)});
  if (has_box) scene.boxes.push_back({Eigen::Vector3d(5.03, -0.5, 0.3), Eigen::Vector3d(5.6, 0.5, 1.1)});
  return scene;
}

/// Points of a plane across x, from `low` to `high` in y and z.
Points across(double x, const Eigen::Vector2d& low, const Eigen::Vector2d& high) {
  constexpr double kSpacing = 0.05;
  constexpr double kOffBorders = 0.013;  // of leaves, where a point's leaf is a matter of rounding
  Points points;
  for (double y = low.x() + kOffBorders; y <= high.x(); y += kSpacing) {
    for (double z = low.y() + kOffBorders; z <= high.y(); z += kSpacing) points.emplace_back(x, y, z);
  }
  return points;
}

/// Points throughout a cube of 4 x 4 x 4 leaves, which grids prune to one node.
Points block() {
  Points points;
  for (double x = 0.013; x < 0.8; x += 0.05) {
    const Points slice = across(x, {0, 0}, {0.8, 0.8});
    points.insert(points.end(), slice.begin(), slice.end());
  }
  return points;
}

// Faces that the sensor sees, inside by more than a leaf so that no other surface shares their leaves.
Points wall() { return across(9.03, {-1.5, 0.65}, {1.5, 1.15}); }
Points box() { return across(5.03, {-0.3, 0.5}, {0.3, 0.9}); }

Points survey() {
  Points points = across(9.03, {-2, 0.3}, {2, 2});
  const Points face = across(5.03, {-0.5, 0.3}, {0.5, 1.1});
  points.insert(points.end(), face.begin(), face.end());
  return points;
}

Pose place(int scan) {
  Pose T_map_sensor;
  T_map_sensor.translation = {0.15 * (scan % 10), 0.05 * (scan % 7) - 0.15, 1.5};
  return T_map_sensor;
}

void drive(Mapper& mapper, const ToyScene& world) {
  Random random(1);
  for (int i = 0; i < kScans; ++i) {
    const Scan scan = world.scan(place(i), kPointsOfScan, 0.01, random);
    mapper.update(scan, place(i));
  }
}

double share_claimed(const Mapper& mapper, const Points& points) {
  return fraction_true(points, [&](const Eigen::Vector3d& p_map) { return mapper.claims(p_map, kSigma); });
}

class MapperTest : public testing::TestWithParam<std::string> {
 protected:
  void SetUp() override {
    if (mapper_ == nullptr) GTEST_SKIP() << GetParam() << " is not installed";
  }
  std::unique_ptr<Mapper> mapper_ = make_mapper(GetParam(), kEdge);
};

TEST_P(MapperTest, GoesByItsName) {
  EXPECT_EQ(mapper_->name(), GetParam());
  // Bonxai's headers tell none.
  EXPECT_EQ(mapper_->version().find('.') != std::string::npos, GetParam() != "Bonxai") << mapper_->version();
}

TEST_P(MapperTest, AnEmptyMapClaimsNothing) {
  EXPECT_EQ(share_claimed(*mapper_, survey()), 0);
  EXPECT_TRUE(mapper_->surface().empty());
}

TEST_P(MapperTest, StartsFromASurveyAndClaimsItsPoints) {
  mapper_->start(survey());
  EXPECT_GT(share_claimed(*mapper_, survey()), 0.98);
  EXPECT_EQ(share_claimed(*mapper_, across(7, {-2, 0.3}, {2, 2})), 0);
}

TEST_P(MapperTest, ItsSurfaceIsOnePointOfEachClaimedLeaf) {
  Points points = survey();
  const Points solid = block();
  points.insert(points.end(), solid.begin(), solid.end());
  mapper_->start(points);
  const Points surface = mapper_->surface();
  const VoxelGrid grid{.edge = kEdge};
  std::vector<std::uint64_t> surveyed;
  for (const auto& p : points) surveyed.push_back(grid.key(p)->bits());
  std::vector<std::uint64_t> shown;
  for (const auto& p : surface) shown.push_back(grid.key(p)->bits());
  std::sort(surveyed.begin(), surveyed.end());
  std::sort(shown.begin(), shown.end());
  surveyed.erase(std::unique(surveyed.begin(), surveyed.end()), surveyed.end());
  EXPECT_EQ(shown, surveyed);
}

TEST_P(MapperTest, KeepsAWallThatEveryScanShows) {
  mapper_->start(survey());
  drive(*mapper_, scene(true));
  EXPECT_GT(share_claimed(*mapper_, wall()), 0.95);
  EXPECT_GT(share_claimed(*mapper_, box()), 0.95);
}

TEST_P(MapperTest, ErasesABoxThatVanishedUnlessItIsStatic) {
  mapper_->start(survey());
  ASSERT_GT(share_claimed(*mapper_, box()), 0.98);
  drive(*mapper_, scene(false));
  const double still_claimed = share_claimed(*mapper_, box());
  if (GetParam() == "static map") {
    EXPECT_GT(still_claimed, 0.98);
  } else {
    EXPECT_LT(still_claimed, 0.02);
  }
  EXPECT_GT(share_claimed(*mapper_, wall()), 0.95);
}

TEST_P(MapperTest, AddsWhatAppearedUnlessItIsStatic) {
  mapper_->start(wall());
  drive(*mapper_, scene(true));
  EXPECT_EQ(share_claimed(*mapper_, box()) > 0.95, GetParam() != "static map");
}

TEST_P(MapperTest, NoticesAtFirstSightWhatAppearedUnlessItIsStatic) {
  mapper_->start(wall());
  Random random(1);
  mapper_->update(scene(true).scan(place(0), kPointsOfScan, 0.01, random), place(0));
  const double noticed =
      fraction_true(box(), [&](const Eigen::Vector3d& p_map) { return mapper_->notices(p_map, kSigma); });
  EXPECT_EQ(noticed > 0.95, GetParam() != "static map");
  // One sight alone does not make it surface in the default mode.
  EXPECT_EQ(share_claimed(*mapper_, box()), GetParam() == "evermap default" ? 0 : noticed);
}

TEST_P(MapperTest, MemoryGrowsWithTheMap) {
  const std::size_t empty = mapper_->memory_bytes();
  EXPECT_LT(empty, 1000);
  mapper_->start(survey());
  EXPECT_GT(mapper_->memory_bytes(), empty + 1000);
}

TEST_P(MapperTest, PreparingAScanDoesNotChangeTheMap) {
  mapper_->start(wall());
  Random random(1);
  const Scan scan = scene(true).scan(place(0), kPointsOfScan, 0.01, random);
  const std::size_t memory = mapper_->memory_bytes();
  const std::size_t leaves = mapper_->surface().size();
  const auto integrate = mapper_->prepare(scan, place(0));
  EXPECT_EQ(mapper_->memory_bytes(), memory);
  EXPECT_EQ(mapper_->surface().size(), leaves);
  integrate();
  EXPECT_EQ(mapper_->memory_bytes() > memory, GetParam() != "static map");
}

TEST_P(MapperTest, PointsOutOfTheLidarsRangeAreNotUsed) {
  const auto short_sighted = make_mapper(GetParam(), kEdge, {.min_range = 1, .max_range = 8});
  Scan scan;
  scan.p_sensor = {{0.6, 0, 0}, {10, 0, 0}};
  for (int i = 0; i < 5; ++i) {
    short_sighted->update(scan, place(0));
    mapper_->update(scan, place(0));
  }
  EXPECT_TRUE(short_sighted->surface().empty());
  EXPECT_EQ(mapper_->surface().size(), GetParam() == "static map" ? 0 : 2);
}

std::string test_name(const testing::TestParamInfo<std::string>& info) {
  std::string name;
  for (const char c : info.param) {
    if (std::isalnum(static_cast<unsigned char>(c)) != 0) name += c;
  }
  return name;
}
INSTANTIATE_TEST_SUITE_P(All, MapperTest, testing::ValuesIn(mapper_names()), test_name);

TEST(MakeMapper, AnUnknownNameIsAnErrorThatListsTheNames) {
  try {
    make_mapper("ufo map", kEdge);
    FAIL();
  } catch (const std::invalid_argument& error) {
    const std::string message = error.what();
    EXPECT_NE(message.find("\"ufo map\""), std::string::npos) << message;
    for (const std::string& name : mapper_names()) {
      EXPECT_NE(message.find('"' + name + '"'), std::string::npos) << message << " lacks " << name;
    }
  }
}

TEST(MakeMapper, OnlyWhatIsNoDebianPackageMayBeMissing) {
  for (const std::string& name : mapper_names()) {
    if (name != "UFOMap" && name != "Bonxai") {
      EXPECT_NE(make_mapper(name, kEdge), nullptr) << name;
    }
  }
}

// A sensor that stands still must not shrink the leaves: the mapper hands its memory of places on.
TEST(EvermapMapper, RemembersWhereItLookedFrom) {
  EvermapMapper remembers("", kEdge, Parameters{});
  Parameters forgetful_parameters;
  forgetful_parameters.update.standstill = 0;
  EvermapMapper forgets("", kEdge, forgetful_parameters);
  Random random(1);
  for (EvermapMapper* mapper : {&remembers, &forgets}) mapper->start(survey());
  const VoxelGrid grid{.edge = kEdge};
  const VoxelKey key = *grid.key({9.03, 1.2, 1.0});  // the box does not hide it
  const float before = remembers.gaussian_map()->find(key)->count;
  for (int i = 0; i < 10; ++i) {
    const Scan scan = scene(true).scan(place(0), kPointsOfScan, 0.01, random);
    for (EvermapMapper* mapper : {&remembers, &forgets}) mapper->update(scan, place(0));
  }
  EXPECT_GT(remembers.gaussian_map()->find(key)->count, before);
  EXPECT_GT(forgets.gaussian_map()->find(key)->count, remembers.gaussian_map()->find(key)->count);
}

}  // namespace
}  // namespace evermap
