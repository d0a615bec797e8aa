// SPDX-FileCopyrightText: 2026 the evermap authors
// SPDX-License-Identifier: BSD-3-Clause
#include <algorithm>
#include <vector>

#include <gtest/gtest.h>

#include "experiments/experiment.hpp"

namespace evermap {
namespace {

/// Two trials in each kind of world; the first one or two scans of each only start. The aim is that no scan
/// is believed and wrong (docs/results.md says what is reached over more trials).
TEST(Arena, ShortDrivesAreTrackedAndHardlyAScanIsConfidentlyWrong) {
  evermap::Setup setup;
  setup.is_quick = true;
  int scans = 0;
  int observable = 0;
  int tracked = 0;
  int wrong = 0;
  std::vector<double> errors;
  for (const Unit& round : experiment_arena(setup).units) {
    const Json result = round.compute([](std::size_t, std::size_t) {});
    for (const Json& trial : result["trials"]) {
      scans += trial["scans"].get<int>();
      observable += trial["observable"].get<int>();
      tracked += trial["tracked"].get<int>();
      wrong += trial["wrong"].get<int>();
      for (const Json& error : trial["errors"]) errors.push_back(error.get<double>());
      EXPECT_GE(trial["tracked"].get<double>(), 0.75 * trial["observable"].get<double>()) << trial.dump();
    }
  }
  EXPECT_EQ(scans, 22 * 30);
  EXPECT_GE(observable, 0.99 * scans);
  EXPECT_GE(tracked, 0.94 * observable);
  EXPECT_LE(wrong, 0.01 * scans);
  const auto middle = errors.begin() + static_cast<std::ptrdiff_t>(errors.size() / 2);
  std::nth_element(errors.begin(), middle, errors.end());
  EXPECT_LT(*middle, 0.005);
}

}  // namespace
}  // namespace evermap
