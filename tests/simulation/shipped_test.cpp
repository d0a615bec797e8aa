// SPDX-FileCopyrightText: 2026 the evermap authors
// SPDX-License-Identifier: BSD-3-Clause
#include <map>
#include <string>

#include <gtest/gtest.h>

#include <evermap/simulation/scenario_drive.hpp>

namespace evermap {
namespace {

class Shipped : public testing::TestWithParam<std::string> {};

TEST_P(Shipped, FirstAndLastScanAreFullOfReturns) {
  const ScenarioDrive drive(shipped_scenario(GetParam()));
  for (const std::size_t i : {std::size_t{0}, drive.size() - 1}) {
    const LabelledScan labelled = drive.scan(i);
    EXPECT_GT(labelled.object.size(), 30000u) << i;
    EXPECT_LT(labelled.object.size(), 64000u) << i;
    EXPECT_EQ(labelled.object.size(), labelled.scan.p_sensor.size());
  }
}

INSTANTIATE_TEST_SUITE_P(All, Shipped, testing::ValuesIn(shipped_scenario_names()),
                         [](const auto& name) { return name.param; });

TEST(ShippedScenarios, AreFour) {
  EXPECT_EQ(shipped_scenario_names(), (std::vector<std::string>{"passing", "quarry", "street", "yard"}));
}

TEST(ShippedScenarios, QuarryLooksFar) {
  const ScenarioDrive drive(shipped_scenario("quarry"));
  EXPECT_GE(drive.size(), 600u);
  std::size_t returns = 0;
  std::size_t far = 0;
  constexpr std::size_t kScans = 6;
  for (std::size_t k = 0; k < kScans; ++k) {
    const LabelledScan labelled = drive.scan(100 * k);
    returns += labelled.object.size();
    for (const Eigen::Vector3d& p : labelled.scan.p_sensor) far += p.norm() > 60 && p.norm() < 150 ? 1 : 0;
  }
  EXPECT_NEAR(static_cast<double>(returns) / kScans, 42000, 2500);
  EXPECT_GT(static_cast<double>(far) / static_cast<double>(returns), 0.15);
}

TEST(ShippedScenarios, PassingIsQuietBetweenAndAtTheEnd) {
  const ScenarioDrive drive(shipped_scenario("passing"));
  ASSERT_GE(drive.size(), 400u);
  const auto moving = [&](std::size_t i) {
    std::map<std::string, int> count;
    for (const int object : drive.scan(i).object) {
      if (drive.class_of(object) == ObjectClass::kHighDynamic) ++count[drive.name_of(object)];
    }
    return count;
  };
  EXPECT_GT(moving(100)["pedestrian"], 20);
  EXPECT_TRUE(moving(205).empty());
  EXPECT_GT(moving(275)["cyclist"], 20);
  EXPECT_TRUE(moving(355).empty());
  EXPECT_GT(moving(420)["van"], 100);
  EXPECT_TRUE(moving(drive.size() - 41).empty());
  EXPECT_TRUE(moving(drive.size() - 1).empty());
}

TEST(ShippedScenarios, StreetDoesNotChangeDuringTheDrive) {
  for (const ScenarioObject& object : shipped_scenario("street").objects) {
    EXPECT_FALSE(object.run && object.run->changes()) << object.name;
  }
}

}  // namespace
}  // namespace evermap
