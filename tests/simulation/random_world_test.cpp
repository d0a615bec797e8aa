// SPDX-FileCopyrightText: 2026 the evermap authors
// SPDX-License-Identifier: BSD-3-Clause
#include <set>
#include <string>

#include <gtest/gtest.h>

#include <evermap/simulation/random_world.hpp>
#include <evermap/simulation/scenario_drive.hpp>

namespace evermap {
namespace {

/// Of a few scans by few beams: what costs is the world.
RandomDrive small_drive() {
  RandomDrive drive;
  drive.channels = 16;
  drive.columns = 128;
  drive.scans = 20;
  drive.changed = 0.3;
  return drive;
}

class RandomWorld : public ::testing::TestWithParam<std::string_view> {};

/// No object stands in the robot's way, whatever the seed, and there is always something to see.
TEST_P(RandomWorld, CanBeDrivenThrough) {
  for (std::uint64_t seed = 1; seed <= 8; ++seed) {
    RandomDrive drive = small_drive();
    drive.starts_at_speed = seed % 2 == 0;
    const ScenarioDrive driven(parse_scenario("world", random_world(GetParam(), seed, drive)));
    ASSERT_EQ(driven.size(), 20U);
    for (const std::size_t scan : {0U, 10U, 19U}) EXPECT_GT(driven.scan(scan).scan.p_sensor.size(), 500U);
    const double way = (driven.T_map_sensor(19).translation - driven.T_map_sensor(0).translation).norm();
    EXPECT_GT(way, 0.1) << "seed " << seed;
  }
}

TEST_P(RandomWorld, IsTheSameForTheSameSeedAlone) {
  std::set<std::string> texts;
  for (std::uint64_t seed = 1; seed <= 10; ++seed) {
    const std::string text = random_world(GetParam(), seed, small_drive());
    EXPECT_EQ(text, random_world(GetParam(), seed, small_drive()));
    texts.insert(text.substr(text.find('\n')));  // what follows the seed itself
  }
  EXPECT_EQ(texts.size(), 10U);
}

TEST_P(RandomWorld, IsAsSurveyedWhenNothingChanged) {
  RandomDrive drive = small_drive();
  drive.changed = 0;
  for (const ScenarioObject& object : parse_scenario("world", random_world(GetParam(), 3, drive)).objects) {
    EXPECT_EQ(object.object_class, ObjectClass::kStatic) << object.name;
  }
}

INSTANTIATE_TEST_SUITE_P(Kinds, RandomWorld, ::testing::ValuesIn(kWorldKinds),
                         [](const auto& kind) { return std::string(kind.param); });

}  // namespace
}  // namespace evermap
