// SPDX-FileCopyrightText: 2026 the evermap authors
// SPDX-License-Identifier: BSD-3-Clause
#include "io/export_fixture.hpp"
#include <evermap/io/cloud.hpp>
#include <evermap/io/map_export.hpp>

namespace evermap {
namespace {

using MapExportTest = ExportTest;

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

TEST_F(MapExportTest, EmptyMapsCanBeExported) {
  const Octree empty(VoxelGrid{0.2});
  for (const char* name : {"map.pcd", "map.ply"}) {
    export_map(empty, path(name));
    EXPECT_FALSE(content(path(name)).empty());
  }
}

TEST_F(MapExportTest, UnknownExtensionsAreRefused) {
  for (const char* name : {"map.ot", "map", "map.pcd.gz"}) {
    file_error(path(name), "known are .pcd and .ply", [&] { export_map(octree_, path(name)); });
    file_error(path(name), "known are .pcd and .ply", [&] { check_export_extension(path(name)); });
  }
  check_export_extension("map.PLY");
  EXPECT_EQ(files_in_folder(), 0U);
}

}  // namespace
}  // namespace evermap
