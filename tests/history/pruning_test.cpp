// SPDX-FileCopyrightText: 2026 the evermap authors
// SPDX-License-Identifier: BSD-3-Clause
#include <gtest/gtest.h>

#include <evermap/history/detail/pruning.hpp>

namespace evermap {
namespace {

constexpr std::int64_t kDay = 24 * 3600;

TEST(Pruning, KeepsTheYoungTheLastOfDaysTheTaggedAndTheNewest) {
  const std::int64_t now = 1000 * kDay + 10;
  const std::vector<std::int64_t> ages = {500 * kDay,    400 * kDay,    40 * kDay + 5,
                                          40 * kDay + 3, 40 * kDay + 1, 39 * kDay,
                                          20 * kDay,     20 * kDay - 1, 5};
  std::vector<StoredVersion> versions(ages.size());
  for (std::size_t i = 0; i < ages.size(); ++i) versions[i].time = now - ages[i];
  versions[1].tags = {"spring"};
  versions[2].tags = {"summer"};
  EXPECT_EQ(which_to_keep(versions, 30 * kDay, 365 * kDay, now),
            (std::vector<bool>{false, true, true, false, true, true, true, true, true}));
  EXPECT_EQ(which_to_keep(versions, 0, 0, now),
            (std::vector<bool>{false, true, true, false, false, false, false, false, true}));
  EXPECT_TRUE(which_to_keep({}, 0, 0, now).empty());
}

}  // namespace
}  // namespace evermap
