// SPDX-FileCopyrightText: 2026 the evermap authors
// SPDX-License-Identifier: BSD-3-Clause
#include <algorithm>
#include <random>
#include <sstream>
#include <tuple>
#include <vector>

#include <octomap/ColorOcTree.h>
#include <octomap/OcTree.h>

#include "files/file_fixture.hpp"
#include <evermap/io/cloud.hpp>

namespace evermap {
namespace {

using Voxels = std::vector<std::tuple<double, double, double>>;

/// Scattered voxels, free and occupied, and cubes of them that OctoMap prunes.
template <class Tree>
void fill(Tree& tree, std::mt19937& generator) {
  std::uniform_real_distribution<float> coordinate(-20, 20);
  std::bernoulli_distribution is_occupied(0.5);
  const auto draw_point = [&] {
    const float x = coordinate(generator);
    const float y = coordinate(generator);
    return octomap::point3d(x, y, coordinate(generator));
  };
  for (int i = 0; i < 300; ++i) {
    const octomap::point3d point = draw_point();
    tree.updateNode(point, is_occupied(generator));
  }
  for (int cube = 0; cube < 3; ++cube) {
    octomap::OcTreeKey corner = tree.coordToKey(draw_point());
    for (int axis = 0; axis < 3; ++axis) corner[axis] = static_cast<octomap::key_type>(corner[axis] & ~7U);
    for (unsigned i = 0; i < 512; ++i) {
      tree.updateNode(octomap::OcTreeKey(static_cast<octomap::key_type>(corner[0] + (i & 7U)),
                                         static_cast<octomap::key_type>(corner[1] + ((i >> 3) & 7U)),
                                         static_cast<octomap::key_type>(corner[2] + (i >> 6))),
                      2.0F);
    }
  }
  tree.updateInnerOccupancy();
  tree.prune();
}

/// What OctoMap itself calls occupied, voxel by voxel.
template <class Tree>
Voxels occupied_in(Tree tree) {
  tree.expand();
  Voxels voxels;
  for (auto leaf = tree.begin_leafs(); leaf != tree.end_leafs(); ++leaf) {
    if (tree.isNodeOccupied(*leaf)) voxels.emplace_back(leaf.getX(), leaf.getY(), leaf.getZ());
  }
  std::sort(voxels.begin(), voxels.end());
  return voxels;
}

Voxels voxels_of(const Scan& cloud) {
  Voxels voxels;
  voxels.reserve(cloud.p_sensor.size());
  for (const Eigen::Vector3d& p : cloud.p_sensor) voxels.emplace_back(p.x(), p.y(), p.z());
  std::sort(voxels.begin(), voxels.end());
  return voxels;
}

template <class Tree>
std::string full(const Tree& tree) {
  std::ostringstream stream;
  tree.write(stream);
  return stream.str();
}

std::string binary(octomap::OcTree tree) {
  std::ostringstream stream;
  tree.writeBinary(stream);
  return stream.str();
}

class OctomapFileTest : public FileTest {
 protected:
  void SetUp() override {
    testing::internal::CaptureStderr();  // OctoMap prints while it writes
  }
  void TearDown() override { testing::internal::GetCapturedStderr(); }

  std::mt19937 generator_{11};
};

TEST_F(OctomapFileTest, HasTheVoxelsThatOctomapCallsOccupied) {
  for (const double resolution : {0.05, 0.2, 1.0}) {
    octomap::OcTree tree(resolution);
    fill(tree, generator_);
    const Voxels occupied = occupied_in(tree);
    ASSERT_GT(occupied.size(), 1500U);
    CloudNotes notes;
    EXPECT_TRUE(voxels_of(read_cloud(make("map.bt", binary(tree)), {}, &notes)) == occupied);
    EXPECT_EQ(notes.voxel, resolution);
    EXPECT_TRUE(voxels_of(read_cloud(make("map.ot", full(tree)))) == occupied);
    octomap::ColorOcTree coloured(resolution);
    fill(coloured, generator_);
    EXPECT_TRUE(voxels_of(read_cloud(make("map.ot", full(coloured)))) == occupied_in(coloured));
  }
}

TEST_F(OctomapFileTest, CutOffAnywhereItIsRefused) {
  octomap::OcTree tree(0.2);
  tree.updateNode(octomap::point3d(1, 2, 3), true);
  tree.updateNode(octomap::point3d(-1, 2, 3), true);
  for (const auto& [name, whole] : {std::pair{"map.bt", binary(tree)}, std::pair{"map.ot", full(tree)}}) {
    for (std::size_t size = 1; size < whole.size(); ++size)
      EXPECT_THROW(read_cloud(make(name, whole.substr(0, size))), FileError) << size;
  }
}

TEST_F(OctomapFileTest, NoByteDoesHarm) {
  octomap::OcTree tree(0.2);
  tree.updateNode(octomap::point3d(1, 2, 3), true);
  for (const auto& [name, whole] : {std::pair{"map.bt", binary(tree)}, std::pair{"map.ot", full(tree)}}) {
    for (std::size_t at = 0; at < whole.size(); ++at) {
      for (const char value : {'\0', '\xFF'}) {
        std::string damaged = whole;
        damaged[at] = value;
        try {
          read_cloud(make(name, damaged));
        } catch (const FileError&) {
        }
      }
    }
  }
}

TEST_F(OctomapFileTest, WhatIsNoneIsNamed) {
  const auto refused = [&](const std::string& bytes, std::string_view message) {
    const std::filesystem::path file = make("map.bt", bytes);
    file_error(file, message, [&] { read_cloud(file); });
  };
  const std::string head = "# Octomap OcTree binary file\n";
  refused("# another file\n", "is no OctoMap");
  refused(head + "id SemanticOcTree\nsize 1\nres 0.1\ndata\n12", "of kind 'SemanticOcTree'");
  refused(head + "id OcTree\nsize 1\nres 0\ndata\n12", "has no resolution");
  refused(head + "id OcTree\nsize 1\nres 0.1x\ndata\n12", "has no number");
  // A child of the root that is occupied as a whole: 2^45 voxels.
  refused(head + "id OcTree\nsize 2\nres 0.1\ndata\n" + std::string("\x02\0", 2), "occupied voxels");
  EXPECT_TRUE(read_cloud(make("map.bt", head + "id OcTree\nsize 0\nres 0.1\ndata\n")).p_sensor.empty());
}

}  // namespace
}  // namespace evermap
