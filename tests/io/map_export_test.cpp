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
  for (const char* name : {"map.pcd", "map.PLY", "map.las"}) {
    export_map(octree_, path(name));
    const Scan cloud = read_cloud(path(name));
    ASSERT_EQ(cloud.p_sensor.size(), occupied_.size()) << name;
    for (std::size_t i = 0; i < occupied_.size(); ++i) {
      const Gaussian surface = octree_.gaussian(occupied_[i], *octree_.find(occupied_[i]));
      EXPECT_LT((cloud.p_sensor[i] - surface.mean).norm(), name == std::string("map.las") ? 1e-3 : 1e-5)
          << name;
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

TEST_F(MapExportTest, TilesHoldAllLeavesEachInItsPlace) {
  constexpr double kEdge = 10;  // [m]
  const std::size_t tiles = export_tiles(octree_, path("tiles"), kEdge);
  EXPECT_GT(tiles, 1U);
  std::size_t points = 0;
  std::size_t files = 0;
  const std::string metadata = content(path("tiles") / "pointcloud_map_metadata.yaml");
  EXPECT_NE(metadata.find("x_resolution: 10.000000\n"), std::string::npos) << metadata;
  for (const auto& entry : std::filesystem::directory_iterator(path("tiles"))) {
    if (entry.path().extension() != ".pcd") continue;
    ++files;
    const std::string name = entry.path().filename().string();
    const std::size_t at = metadata.find("\n" + name + ": [");
    ASSERT_NE(at, std::string::npos) << name;
    double x = 0, y = 0;
    ASSERT_EQ(std::sscanf(metadata.c_str() + at + 1 + name.size(), ": [%lf, %lf]", &x, &y), 2);
    for (const Eigen::Vector3d& p : read_cloud(entry.path()).p_sensor) {
      ++points;
      EXPECT_TRUE(p.x() >= x - 1e-4 && p.x() <= x + kEdge + 1e-4) << name;
      EXPECT_TRUE(p.y() >= y - 1e-4 && p.y() <= y + kEdge + 1e-4) << name;
    }
  }
  EXPECT_EQ(files, tiles);
  EXPECT_EQ(points, occupied_.size());
}

/// Ground that rises, a wall on it, a roof above, and a car whose inside nobody saw.
TEST_F(MapExportTest, AnOccupancyGridShowsWhereOneCanDrive) {
  Octree octree(VoxelGrid{0.5});
  const auto put = [&](double x, double y, double z) {
    Leaf& leaf = octree.find_or_insert(octree.grid().key(Eigen::Vector3d(x, y, z)).value());
    leaf.log_odds = 1;
    leaf.mean_in_voxel =
        (Eigen::Vector3d(x, y, z) - octree.grid().center(octree.grid().key({x, y, z}).value())).cast<float>();
  };
  const auto ground = [](double x) { return 0.1 * x; };
  const auto is_car = [](double x, double y) { return x > 4 && x < 8 && y > 4 && y < 6; };
  for (double x = 0.25; x < 20; x += 0.5) {
    for (double y = 0.25; y < 10; y += 0.5) {
      if (x > 12 && x < 13 && y < 2) continue;  // never seen
      put(x, y, is_car(x, y) ? ground(x) + 1.6 : ground(x));
      if (x > 14) put(x, y, ground(x) + 3);  // the roof
    }
  }
  for (double z = 0; z < 2; z += 0.5) put(10.25, 8.25, ground(10.25) + z);
  export_map(octree, path("map.pgm"));
  const std::string picture = content(path("map.pgm"));
  const std::string head = "P5\n40 20\n255\n";
  ASSERT_TRUE(picture.starts_with(head));
  ASSERT_EQ(picture.size(), head.size() + 40 * 20);
  const auto at = [&](double x, double y) {
    const auto column = static_cast<std::size_t>(x / 0.5);
    const auto row = 19 - static_cast<std::size_t>(y / 0.5);
    return static_cast<unsigned char>(picture[head.size() + row * 40 + column]);
  };
  EXPECT_EQ(at(2, 2), 254);
  EXPECT_EQ(at(18, 5), 254);      // below the roof
  EXPECT_EQ(at(10.25, 8.25), 0);  // the wall
  EXPECT_EQ(at(6, 5), 0);         // the middle of the car's roof
  EXPECT_EQ(at(12.5, 1), 205);
  const std::string yaml = content(path("map.yaml"));
  EXPECT_NE(yaml.find("image: map.pgm\n"), std::string::npos) << yaml;
  EXPECT_NE(yaml.find("resolution: 0.5\norigin: [0, 0, 0.0]\n"), std::string::npos) << yaml;
}

TEST_F(MapExportTest, EmptyMapsCanBeExported) {
  const Octree empty(VoxelGrid{0.2});
  for (const char* name : {"map.pcd", "map.ply", "map.las", "map.pgm"}) {
    export_map(empty, path(name));
    EXPECT_FALSE(content(path(name)).empty());
  }
}

TEST_F(MapExportTest, UnknownExtensionsAreRefused) {
  for (const char* name : {"map.ot", "map", "map.pcd.gz"}) {
    file_error(path(name), "known are .pcd, .ply, .las and .pgm", [&] { export_map(octree_, path(name)); });
    file_error(path(name), "known are .pcd, .ply, .las and .pgm",
               [&] { check_export_extension(path(name)); });
  }
  check_export_extension("map.PLY");
  EXPECT_EQ(files_in_folder(), 0U);
}

}  // namespace
}  // namespace evermap
