// SPDX-FileCopyrightText: 2026 the evermap authors
// SPDX-License-Identifier: BSD-3-Clause
#include <algorithm>
#include <map>
#include <string>
#include <support/random_geometry.hpp>
#include <utility>
#include <vector>

#include <gtest/gtest.h>

#include <evermap/map/detail/wide_node.hpp>

namespace evermap {
namespace {

using test::Random;
using Node = WideNode<std::string>;
using NodeTwin = std::map<int, std::string>;

void expect_equal(const Node& node, const NodeTwin& twin) {
  EXPECT_EQ(node.size(), twin.size());
  EXPECT_EQ(node.empty(), twin.empty());
  EXPECT_GE(node.capacity(), node.size());
  std::vector<std::pair<int, std::string>> visited;
  node.for_each([&](int index, const std::string& child) { visited.emplace_back(index, child); });
  EXPECT_EQ(visited, (std::vector<std::pair<int, std::string>>(twin.begin(), twin.end())));
  for (int index = 0; index < Node::kChildren; ++index) {
    const auto expected = twin.find(index);
    const std::string* found = node.find(index);
    ASSERT_EQ(node.has(index), expected != twin.end());
    ASSERT_EQ(found != nullptr, expected != twin.end());
    if (!found) continue;
    EXPECT_EQ(*found, expected->second);
  }
}

/// Random insertions and erasures, with phases in which the node fills up and empties.
TEST(WideNode, BehavesLikeAMap) {
  Random random(1);
  Node node;
  NodeTwin twin;
  std::size_t fullest = 0;
  for (int i = 0; i < 20000; ++i) {
    const double share_of_insertions = i / 2500 % 2 == 0 ? 0.8 : 0.2;
    const int index = random.integer(0, Node::kChildren - 1);
    if (random.chance(share_of_insertions)) {
      std::string& child = node.find_or_insert(index);
      EXPECT_EQ(child, twin[index]);
      child = twin[index] = std::to_string(i);
    } else {
      node.erase(index);
      twin.erase(index);
    }
    fullest = std::max(fullest, twin.size());
    if (i % 97 == 0) expect_equal(node, twin);
  }
  expect_equal(node, twin);
  EXPECT_GT(fullest, 350U);
}

TEST(WideNode, HoldsAllChildrenInAnyOrderOfInsertion) {
  Node node;
  NodeTwin twin;
  for (int i = 0; i < Node::kChildren; ++i) {
    const int index = i * 149 % Node::kChildren;
    node.find_or_insert(index) = twin[index] = std::to_string(index);
  }
  expect_equal(node, twin);
  for (int index = 0; index < Node::kChildren; ++index) node.erase(Node::kChildren - 1 - index);
  expect_equal(node, {});
}

TEST(WideNode, BordersOfWords) {
  Node node;
  NodeTwin twin;
  for (const int index : {511, 0, 63, 64, 127, 128, 448, 447}) {
    EXPECT_EQ(node.find(index), nullptr);
    node.find_or_insert(index) = twin[index] = std::to_string(index);
    expect_equal(node, twin);
  }
  *node.find(64) = twin[64] = "changed";
  node.erase(63);
  node.erase(63);
  twin.erase(63);
  expect_equal(node, twin);
}

TEST(Mask512, BoundsAreTheLeastBox) {
  Random random(2);
  for (int i = 0; i < 2000; ++i) {
    Mask512 mask;
    EXPECT_TRUE(mask.empty());
    Eigen::AlignedBox3i expected;
    for (int set = random.integer(1, 12); set > 0; --set) {
      const Eigen::Vector3i at(random.integer(0, 7), random.integer(0, 7), random.integer(0, 7));
      mask.set(at.z() << 6 | at.y() << 3 | at.x());
      expected.extend(at);
    }
    EXPECT_FALSE(mask.empty());
    EXPECT_EQ(mask.bounds().min(), expected.min());
    EXPECT_EQ(mask.bounds().max(), expected.max());
  }
}

}  // namespace
}  // namespace evermap
