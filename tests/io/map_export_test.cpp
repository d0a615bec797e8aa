// SPDX-FileCopyrightText: 2026 the evermap authors
// SPDX-License-Identifier: BSD-3-Clause
#include <octomap/OcTree.h>

#include "files/file_fixture.hpp"
#include "support/random_octree.hpp"
#include <evermap/io/cloud.hpp>
#include <evermap/io/map_export.hpp>

namespace evermap {
namespace {

class MapExportTest : public FileTest {
 protected:
  MapExportTest() : octree_(VoxelGrid{0.2}) {
    std::mt19937 generator(7);
    octree_ = random_octree(generator, 3000, VoxelGrid{0.2});
    octree_.for_each_leaf([&](VoxelKey key, const Leaf& leaf) {
      if (leaf.occupied()) occupied_.push_back(key);
    });
  }

  Octree octree_;
  std::vector<VoxelKey> occupied_;
};

TEST_F(MapExportTest, CloudsHoldTheMeansOfOccupiedLeaves) {
  ASSERT_GT(octree_.leaf_count(), occupied_.size());
  for (const char* name : {"map.pcd", "map.PLY"}) {
    export_map(octree_, path(name));
    const Scan cloud = read_cloud(path(name));
    ASSERT_EQ(cloud.p_sensor.size(), occupied_.size()) << name;
    for (std::size_t i = 0; i < occupied_.size(); ++i) {
      const Gaussian surface = octree_.gaussian(occupied_[i], *octree_.find(occupied_[i]));
      EXPECT_LT((cloud.p_sensor[i] - surface.mean).norm(), 1e-5) << name;
    }
  }
}

TEST_F(MapExportTest, APointCarriesTheWholeLeaf) {
  Octree octree(VoxelGrid{0.5});
  Leaf& leaf = octree.find_or_insert(VoxelKey::from_voxel({0, 0, 0}));
  leaf = {{0.25F, 0, 0}, {1, 2, 3, 4, 5, 6}, 7, 0.5F};
  const auto probability = static_cast<float>(1 / (1 + std::exp(-0.5)));
  const std::string row = bytes_of<float>({0.5F, 0.25F, 0.25F, 1, 2, 3, 4, 5, 6, probability, 7});
  export_map(octree, path("map.pcd"));
  EXPECT_TRUE(content(path("map.pcd")).ends_with("DATA binary\n" + row));
  EXPECT_NE(content(path("map.pcd"))
                .find("FIELDS x y z cov_xx cov_xy cov_xz cov_yy cov_yz cov_zz occupancy count\n"),
            std::string::npos);
  export_map(octree, path("map.ply"));
  EXPECT_TRUE(content(path("map.ply")).ends_with("property float count\nend_header\n" + row));
}

TEST_F(MapExportTest, FarFromTheOriginMillimetresAreKept) {
  const VoxelGrid grid = VoxelGrid::around({691'000, 5'334'000, 500}, 0.2);
  std::mt19937 generator(3);
  const Octree octree = random_octree(generator, 100, grid);
  for (const char* name : {"map.pcd", "map.ply"}) {
    export_map(octree, path(name));
    const Scan cloud = read_cloud(path(name));
    std::size_t i = 0;
    octree.for_each_leaf([&](VoxelKey key, const Leaf& leaf) {
      if (!leaf.occupied()) return;
      EXPECT_LT((cloud.p_sensor.at(i++) - octree.gaussian(key, leaf).mean).norm(), 1e-6);
    });
    EXPECT_EQ(i, cloud.p_sensor.size());
  }
}

TEST_F(MapExportTest, OctomapReadsOccupancyBack) {
  export_map(octree_, path("map.ot"));
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

TEST_F(MapExportTest, OctomapReadsTheBinaryFormBack) {
  testing::internal::CaptureStderr();
  export_map(octree_, path("map.bt"));
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

TEST_F(MapExportTest, EmptyMapsCanBeExported) {
  const Octree empty(VoxelGrid{0.2});
  for (const char* name : {"map.pcd", "map.ply", "map.ot", "map.bt"}) {
    export_map(empty, path(name));
    EXPECT_FALSE(content(path(name)).empty());
  }
}

TEST_F(MapExportTest, MapsBeyondOctomapsKeysAreRefused) {
  const Octree far = [] {
    std::mt19937 generator(3);
    return random_octree(generator, 100, VoxelGrid::around({691'000, 5'334'000, 500}, 0.2));
  }();
  for (const char* name : {"map.ot", "map.bt"}) {
    file_error(path(name), "export it as .pcd or .ply", [&] { export_map(far, path(name)); });
  }
  EXPECT_EQ(files_in_folder(), 0U);
}

TEST_F(MapExportTest, UnknownExtensionsAreRefused) {
  for (const char* name : {"map.las", "map", "map.pcd.gz"}) {
    file_error(path(name), "known are .pcd, .ply, .ot and .bt", [&] { export_map(octree_, path(name)); });
    file_error(path(name), "known are .pcd, .ply, .ot and .bt", [&] { check_export_extension(path(name)); });
  }
  check_export_extension("map.OT");
  EXPECT_EQ(files_in_folder(), 0U);
}

}  // namespace
}  // namespace evermap
