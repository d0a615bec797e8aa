// SPDX-FileCopyrightText: 2026 the evermap authors
// SPDX-License-Identifier: BSD-3-Clause
#include "experiments/pcl_localizer.hpp"

#include <gtest/gtest.h>

#include <evermap/geometry/detail/degree.hpp>
#include <evermap/localization/detail/perturbation.hpp>
#include <evermap/simulation/scenario_drive.hpp>

namespace evermap {
namespace {

class PclLocalizerTest : public ::testing::TestWithParam<std::string_view> {};

// A rival that could not follow an easy drive would prove nothing where it is hard.
TEST_P(PclLocalizerTest, FollowsAnEasyDrive) {
  if (!PclLocalizer::is_available()) GTEST_SKIP() << "built without PCL";
  const ScenarioDrive yard(shipped_scenario("yard"));
  constexpr std::size_t kScans = 4;
  std::vector<Eigen::Vector3d> map;  // as the sensor sees it: a survey has the far faces of walls, too
  for (std::size_t i = 0; i < kScans; ++i) {
    for (const Eigen::Vector3d& p : yard.in_map(i, yard.scan(i).scan)) map.push_back(p);
  }
  PclLocalizer localizer(GetParam(), map, yard.T_map_sensor(0), 0.1);
  for (std::size_t i = 0; i < kScans; ++i) {
    const Pose truth = yard.T_map_sensor(i);
    const std::optional<Pose> found = localizer.locate(yard.scan(i).scan, std::nullopt);
    ASSERT_TRUE(found) << i;
    const Twist off = difference(truth, *found);
    EXPECT_LT(off.head<3>().norm(), 0.15) << i;
    EXPECT_LT(off.tail<3>().norm(), kDegree) << i;
  }
}

INSTANTIATE_TEST_SUITE_P(Methods, PclLocalizerTest, ::testing::ValuesIn(PclLocalizer::kMethods),
                         [](const auto& method) {
                           std::string name(method.param);
                           std::erase(name, ' ');
                           return name;
                         });

}  // namespace
}  // namespace evermap
