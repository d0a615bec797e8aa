// SPDX-FileCopyrightText: 2026 the evermap authors
// SPDX-License-Identifier: BSD-3-Clause
#include "experiments/closed_loop.hpp"

#include <gtest/gtest.h>

#include <evermap/simulation/scenario_drive.hpp>

namespace evermap {
namespace {

// A rival that is not let in at the start would prove nothing of what becomes of its map.
TEST(ClosedLoopOfAGrid, FollowsAnEasyDrive) {
  constexpr double kEdge = 0.4;  // [m]
  constexpr std::size_t kScans = 8;
  const ScenarioDrive yard(shipped_scenario("yard"));
  const auto mapper = make_mapper("OctoMap", kEdge);
  mapper->start(yard.survey(kEdge / 4), yard.T_map_sensor(0));
  ClosedLoop loop(*mapper, kEdge, yard.T_map_sensor(0), {});
  for (std::size_t i = 0; i < kScans; ++i)
    loop.process(yard.scan(i).scan, yard.time(i), std::nullopt, yard.T_map_sensor(i));
  const Json errors = loop.errors();
  EXPECT_LT(errors["worst"], 0.4) << errors;
  EXPECT_EQ(errors["lost"], 0) << errors;
  EXPECT_GE(errors["tracked"], 0.7) << errors;
}

}  // namespace
}  // namespace evermap
