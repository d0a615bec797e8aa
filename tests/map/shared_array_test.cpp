// SPDX-FileCopyrightText: 2026 the evermap authors
// SPDX-License-Identifier: BSD-3-Clause
#include <algorithm>
#include <memory>
#include <support/random_geometry.hpp>
#include <vector>

#include <gtest/gtest.h>

#include <evermap/map/detail/shared_array.hpp>

namespace evermap {
namespace {

using test::Random;
using Value = std::shared_ptr<int>;
using Array = SharedArray<Value>;
using Values = std::vector<Value>;

Values elements(const Array& array) { return {array.data(), array.data() + array.size()}; }

/// Arrays that are copied from one another and changed at random, each beside a vector that shares nothing.
TEST(SharedArray, CopiesBehaveLikeVectorsOfTheirOwn) {
  Random random(1);
  std::vector<Array> arrays(5);
  std::vector<Values> twins(5);
  std::size_t longest = 0;
  for (int i = 0; i < 30000; ++i) {
    const auto a = static_cast<std::size_t>(random.integer(0, 4));
    const auto b = static_cast<std::size_t>(random.integer(0, 4));
    const Value value = std::make_shared<int>(i);  // whose destruction shows
    const auto place = [&](std::size_t size) {
      return static_cast<std::size_t>(random.integer(0, static_cast<int>(size) - 1));
    };
    switch (random.integer(0, 9)) {
      case 0:
        arrays[a] = arrays[b];
        twins[a] = twins[b];
        break;
      case 1:
        if (!twins[a].empty()) {
          const std::size_t at = place(twins[a].size());
          arrays[a].erase(at);
          twins[a].erase(twins[a].begin() + static_cast<std::ptrdiff_t>(at));
        }
        break;
      case 2:
      case 3:
      case 4:
        if (!twins[a].empty()) {
          const std::size_t at = place(twins[a].size());
          arrays[a].own(at) = twins[a][at] = value;
        }
        break;
      default: {
        const std::size_t at = place(twins[a].size() + 1);
        Value& inserted = arrays[a].insert(at);
        EXPECT_EQ(inserted, nullptr);
        inserted = value;
        twins[a].insert(twins[a].begin() + static_cast<std::ptrdiff_t>(at), value);
      }
    }
    longest = std::max(longest, twins[a].size());
    if (random.chance(0.001)) arrays[a] = Array(twins[a]);
    if (random.chance(0.002)) arrays[a] = Array(), twins[a].clear();
    if (i % 50 != 0) continue;
    for (std::size_t k = 0; k < arrays.size(); ++k) ASSERT_EQ(elements(arrays[k]), twins[k]);
  }
  EXPECT_GT(longest, 100U);
}

TEST(SharedArray, ACopyTakesNoMemoryUntilItIsChanged) {
  const Value a = std::make_shared<int>(1);
  const Value b = std::make_shared<int>(2);
  Array array(Values{a, b});
  EXPECT_EQ(a.use_count(), 2);
  Array copy = array;
  EXPECT_EQ(copy.data(), array.data());
  EXPECT_EQ(a.use_count(), 2);
  copy.own(1) = nullptr;
  EXPECT_NE(copy.data(), array.data());
  EXPECT_EQ(elements(array), (Values{a, b}));
  EXPECT_EQ(elements(copy), (Values{a, nullptr}));
  const Value* before = copy.data();
  copy.own(1) = b;  // its own already
  EXPECT_EQ(copy.data(), before);
  array = Array();
  copy = array;
  EXPECT_EQ(a.use_count(), 1);  // nothing is left over
}

}  // namespace
}  // namespace evermap
