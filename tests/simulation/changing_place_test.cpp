// SPDX-FileCopyrightText: 2026 the evermap authors
// SPDX-License-Identifier: BSD-3-Clause
#include <set>
#include <sstream>
#include <string>

#include <gtest/gtest.h>

#include <evermap/simulation/changing_place.hpp>
#include <evermap/simulation/scenario.hpp>

namespace evermap {
namespace {

/// Shapes and places of the objects, whatever their names.
std::multiset<std::string> objects_of(const std::string& text) {
  std::multiset<std::string> objects;
  std::istringstream lines(text.substr(text.find("objects:")));
  for (std::string line; std::getline(lines, line);) {
    if (const auto shape = line.find(", "); shape != std::string::npos) objects.insert(line.substr(shape));
  }
  return objects;
}

double kept_fraction(std::string_view place, int from, int to, const RandomDrive& drive) {
  const auto before = objects_of(changing_place(place, 3, from, drive));
  const auto after = objects_of(changing_place(place, 3, to, drive));
  std::size_t kept = 0;
  for (const std::string& object : before) kept += after.count(object) > 0 ? 1 : 0;
  return static_cast<double>(kept) / static_cast<double>(before.size());
}

TEST(ChangingPlace, IsAScenarioOnAnyNightAndOfAnySeed) {
  for (const std::string_view place : kChangingPlaces) {
    for (const int nights : {0, 1, 17, 40}) {
      for (const std::uint64_t seed : {1, 2}) {
        const std::string text = changing_place(place, seed, nights, {.scans = 12});
        EXPECT_EQ(parse_scenario("place", text).scans, 12);
        EXPECT_EQ(text, changing_place(place, seed, nights, {.scans = 12}));
      }
    }
  }
  EXPECT_NE(changing_place("pit", 1, 0, {}), changing_place("pit", 2, 0, {}));
}

TEST(ChangingPlace, ChangesByAFractionEachNightAndAlmostWhollyInAYear) {
  for (const std::string_view place : kChangingPlaces) {
    EXPECT_EQ(kept_fraction(place, 5, 5, {}), 1);
    EXPECT_GT(kept_fraction(place, 5, 6, {.changed = 0.2}), 0.6);
    EXPECT_LT(kept_fraction(place, 5, 6, {.changed = 0.2}), 1);
    EXPECT_LT(kept_fraction(place, 0, 40, {.changed = 0.2}), 0.2);
  }
  EXPECT_EQ(kept_fraction("container terminal", 0, 40, {.changed = 0}), 1);
}

}  // namespace
}  // namespace evermap
