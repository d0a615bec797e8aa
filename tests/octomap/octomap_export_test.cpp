// SPDX-FileCopyrightText: 2026 the evermap authors
// SPDX-License-Identifier: BSD-3-Clause
#include <memory>
#include <random>
#include <vector>

#include <octomap/OcTree.h>

#include "io/export_fixture.hpp"
#include <evermap/octomap/octomap_export.hpp>

namespace evermap {
namespace {

using OctomapExportTest = ExportTest;

TEST_F(OctomapExportTest, OctomapReadsOccupancyBack) {
  export_map(octree_, path("map.ot"), octomap_formats());
  const std::unique_ptr<octomap::AbstractOcTree> read(octomap::AbstractOcTree::read(path("map.ot").string()));
  const auto* tree = dynamic_cast<octomap::OcTree*>(read.get());
  ASSERT_NE(tree, nullptr);
  EXPECT_NEAR(tree->getResolution(), 0.2, 1e-12);
  for (const VoxelKey key : occupied_) {
    const Eigen::Vector3d center = octree_.grid().center(key);
    const octomap::OcTreeNode* node = tree->search(center.x(), center.y(), center.z());
    ASSERT_NE(node, nullptr);
    EXPECT_EQ(node->getLogOdds(), octree_.find(key)->log_odds);
  }
  EXPECT_EQ(tree->getNumLeafNodes(), occupied_.size());
}

TEST_F(OctomapExportTest, OctomapReadsTheBinaryFormBack) {
  testing::internal::CaptureStderr();
  export_map(octree_, path("map.bt"), octomap_formats());
  EXPECT_EQ(testing::internal::GetCapturedStderr(), "") << "a library prints nothing";
  octomap::OcTree tree(0.1);
  ASSERT_TRUE(tree.readBinary(path("map.bt").string()));
  EXPECT_NEAR(tree.getResolution(), 0.2, 1e-12);
  tree.expand();
  EXPECT_EQ(tree.getNumLeafNodes(), occupied_.size());
  for (const VoxelKey key : occupied_) {
    const Eigen::Vector3d center = octree_.grid().center(key);
    const octomap::OcTreeNode* node = tree.search(center.x(), center.y(), center.z());
    ASSERT_NE(node, nullptr);
    EXPECT_TRUE(tree.isNodeOccupied(node));
  }
}

TEST_F(OctomapExportTest, EmptyMapsCanBeExported) {
  const Octree empty(VoxelGrid{0.2});
  for (const char* name : {"map.ot", "map.bt"}) {
    export_map(empty, path(name), octomap_formats());
    EXPECT_FALSE(content(path(name)).empty());
  }
}

TEST_F(OctomapExportTest, MapsBeyondOctomapsKeysAreRefused) {
  const Octree far = [] {
    std::mt19937 generator(3);
    return random_octree(generator, 100, VoxelGrid::around({691'000, 5'334'000, 500}, 0.2));
  }();
  for (const char* name : {"map.ot", "map.bt"}) {
    file_error(path(name), "export it as .pcd or .ply",
               [&] { export_map(far, path(name), octomap_formats()); });
  }
  EXPECT_EQ(files_in_folder(), 0U);
}

TEST_F(OctomapExportTest, UnknownExtensionsAreRefused) {
  for (const char* name : {"map.pcd", "map", "map.ot.gz"}) {
    file_error(path(name), "known are .ot and .bt",
               [&] { export_map(octree_, path(name), octomap_formats()); });
    file_error(path(name), "known are .ot and .bt",
               [&] { check_export_extension(path(name), octomap_formats()); });
  }
  check_export_extension("map.OT", octomap_formats());
  EXPECT_EQ(files_in_folder(), 0U);
}

}  // namespace
}  // namespace evermap
