// SPDX-FileCopyrightText: 2026 the evermap authors
// SPDX-License-Identifier: BSD-3-Clause
#include <random>

#include <pcl/io/lzf.h>
#include <pcl/io/pcd_io.h>
#include <pcl/io/ply_io.h>
#include <pcl/point_cloud.h>
#include <pcl/point_types.h>

#include "files/file_fixture.hpp"
#include <evermap/io/cloud.hpp>
#include <evermap/io/detail/lzf.hpp>
#include <evermap/io/detail/pcd.hpp>
#include <evermap/io/detail/ply.hpp>

// The Point Cloud Library reads what evermap writes, and evermap what it writes.

namespace evermap {
namespace {

class PclOracleTest : public FileTest {
 protected:
  PclOracleTest() {
    std::mt19937 random(1);
    std::uniform_real_distribution<float> coordinate(-100, 100);
    for (int i = 0; i < 1000; ++i) {
      pcl::PointXYZINormal point;
      point.x = coordinate(random);
      point.y = coordinate(random);
      point.z =
          i % 10 == 0 ? 0.0F : coordinate(random);  // repetitions, so that there is something to compress
      point.intensity = 0.5F;
      cloud_.push_back(point);
    }
    cloud_[17].y = kNaN;
    cloud_[18].x = cloud_[18].y = cloud_[18].z = 0;
  }

  void expect_cloud(const Scan& scan, float tolerance) const {
    EXPECT_EQ(scan.dropped_not_finite, 1U);
    EXPECT_EQ(scan.dropped_at_origin, 1U);
    ASSERT_EQ(scan.p_sensor.size(), cloud_.size() - 2);
    for (std::size_t i = 0; i < scan.p_sensor.size(); ++i) {
      const auto& point = cloud_[i < 17 ? i : i + 2];
      const Eigen::Vector3d expected(point.x, point.y, point.z);
      ASSERT_LE((scan.p_sensor[i] - expected).cwiseAbs().maxCoeff(), tolerance) << i;
    }
  }

  pcl::PointCloud<pcl::PointXYZINormal> cloud_;
};

TEST_F(PclOracleTest, ReadsItsPcd) {
  cloud_.sensor_origin_ = {1, 2, 3, 0};
  cloud_.sensor_orientation_ = Eigen::Quaternionf(0.5F, 0.5F, 0.5F, -0.5F);
  const std::string file = path("a.pcd");
  pcl::PCDWriter writer;
  for (const std::string kind : {"ascii", "binary", "binary_compressed"}) {
    ASSERT_EQ(kind == "ascii"    ? writer.writeASCII(file, cloud_, 9)
              : kind == "binary" ? writer.writeBinary(file, cloud_)
                                 : writer.writeBinaryCompressed(file, cloud_),
              0);
    const Scan scan = read_cloud(file);
    expect_cloud(scan, kind == "ascii" ? 1e-6F : 0);
    ASSERT_TRUE(scan.T_map_sensor) << kind;
    EXPECT_EQ(scan.T_map_sensor->translation, Eigen::Vector3d(1, 2, 3));
    EXPECT_TRUE(scan.T_map_sensor->rotation.isApprox(
        cloud_.sensor_orientation_.cast<double>().toRotationMatrix(), 1e-6));
  }
}

TEST_F(PclOracleTest, ReadsItsPcdWithoutViewpoint) {
  const std::string file = path("a.pcd");
  ASSERT_EQ(pcl::io::savePCDFileBinaryCompressed(file, cloud_), 0);
  EXPECT_FALSE(read_cloud(file).T_map_sensor);
}

TEST_F(PclOracleTest, ReadsItsPly) {
  const std::string file = path("a.ply");
  for (const bool binary : {false, true}) {
    ASSERT_EQ(pcl::io::savePLYFile(file, cloud_, binary), 0);
    expect_cloud(read_cloud(file), binary ? 0 : 1e-3F);
  }
}

TEST_F(PclOracleTest, ReadsOurFiles) {
  PointTable table = {{{"x"}, {"y"}, {"z"}, {"intensity"}}, {}};
  for (const auto& p : cloud_) table.values.insert(table.values.end(), {p.x, p.y, p.z, p.intensity});
  write_pcd(path("a.pcd"), table);
  write_ply(path("a.ply"), table);
  pcl::PointCloud<pcl::PointXYZI> from_pcd, from_ply;
  ASSERT_EQ(pcl::io::loadPCDFile(path("a.pcd"), from_pcd), 0);
  ASSERT_EQ(pcl::io::loadPLYFile(path("a.ply"), from_ply), 0);
  for (const auto& read : {from_pcd, from_ply}) {
    ASSERT_EQ(read.size(), cloud_.size());
    for (std::size_t i = 0; i < read.size(); ++i) {
      if (i == 17) continue;
      ASSERT_EQ(read[i].getVector3fMap(), cloud_[i].getVector3fMap());
      ASSERT_EQ(read[i].intensity, cloud_[i].intensity);
    }
  }
}

TEST_F(PclOracleTest, ReadsOurDoubles) {
  using Type = PointTable::Type;
  const PointTable table = {{{"x", Type::kFloat64}, {"occupancy", Type::kFloat32}},
                            {1e6 + 1e-6, 0.5, -3, 0.25}};
  write_pcd(path("a.pcd"), table);
  write_ply(path("a.ply"), table);
  pcl::PCLPointCloud2 from_pcd, from_ply;
  ASSERT_EQ(pcl::io::loadPCDFile(path("a.pcd"), from_pcd), 0);
  ASSERT_EQ(pcl::io::loadPLYFile(path("a.ply"), from_ply), 0);
  for (const auto& read : {from_pcd, from_ply}) {
    ASSERT_EQ(read.fields.size(), 2U);
    EXPECT_EQ(read.fields[0].datatype, pcl::PCLPointField::FLOAT64);
    EXPECT_EQ(read.at<double>(0, read.fields[0].offset), 1e6 + 1e-6);
    EXPECT_EQ(read.at<float>(1, read.fields[1].offset), 0.25F);
  }
}

TEST_F(PclOracleTest, DecompressesItsLzf) {
  std::mt19937 random(3);
  for (int i = 0; i < 500; ++i) {
    std::string plain(100 + random() % 20000, '\0');
    const std::size_t letters = 1 + random() % 6;
    for (char& c : plain) c = static_cast<char>(random() % letters);
    std::string compressed(plain.size() + 1000, '\0');
    compressed.resize(pcl::lzfCompress(plain.data(), static_cast<unsigned>(plain.size()), compressed.data(),
                                       static_cast<unsigned>(compressed.size())));
    ASSERT_FALSE(compressed.empty());
    std::string output(plain.size(), '?');
    ASSERT_FALSE(lzf_decompress(compressed, output));
    ASSERT_TRUE(output == plain);
  }
}

}  // namespace
}  // namespace evermap
