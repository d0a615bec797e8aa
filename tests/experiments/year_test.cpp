// SPDX-FileCopyrightText: 2026 the evermap authors
// SPDX-License-Identifier: BSD-3-Clause
#include <gtest/gtest.h>

#include "experiments/experiment.hpp"

namespace evermap {
namespace {

const Json& rows_of(const Json& result, const std::string& mapper) {
  for (const Json& of_mapper : result["mappers"]) {
    if (of_mapper["name"] == mapper) return of_mapper["rows"];
  }
  throw std::out_of_range(mapper);
}

TEST(Year, TheMapThatIsKeptFollowsFromDayToDay) {
  evermap::Setup setup;
  setup.is_quick = true;
  const Unit terminal = experiment_year(setup).units.front();
  const Json result = terminal.compute([](std::size_t, std::size_t) {});
  const Json& kept = rows_of(result, "evermap default");
  const Json& still = rows_of(result, "static map");
  ASSERT_EQ(kept.size(), 3U);
  for (const Json& row : kept) {
    EXPECT_LT(row["ATE"], 0.01);
    EXPECT_EQ(row["lost"], 0);
    EXPECT_GT(row["SA"], 0.98);
    EXPECT_GT(row["DA"], 0.7);
    EXPECT_NEAR(row["leaves"].get<double>() / result["fresh leaves"].back().get<double>(), 1, 0.05);
  }
  // Who updates nothing erases nothing, and of what came since the survey it keeps nothing.
  EXPECT_LT(still.back()["DA"], 0.05);
  EXPECT_EQ(still.front()["leaves"], still.back()["leaves"]);
  EXPECT_LT(still.back()["SA"], still.front()["SA"]);
  EXPECT_LT(result["survey left"].back(), result["survey left"].front());
}

}  // namespace
}  // namespace evermap
