// SPDX-FileCopyrightText: 2026 the evermap authors
// SPDX-License-Identifier: BSD-3-Clause
#include <cstdlib>
#include <random>

#include "io/cloud_samples.hpp"
#include <evermap/io/cloud.hpp>
#include <evermap/io/detail/scan_folder.hpp>

namespace evermap {
namespace {

class CloudTest : public FileTest {};

TEST_F(CloudTest, FormatFollowsFromTheExtension) {
  for (const Sample& sample : samples()) {
    const Scan scan = read_cloud(make(sample.name, sample.bytes));
    ASSERT_EQ(scan.p_sensor.size(), 3U) << sample.name;
    EXPECT_EQ(scan.p_sensor[0], Eigen::Vector3d(1, 2, 3)) << sample.name;
    EXPECT_EQ(scan.p_sensor[1], Eigen::Vector3d(4, 5, 6)) << sample.name;
    EXPECT_EQ(scan.p_sensor[2], Eigen::Vector3d(7, 8, 9)) << sample.name;
  }
  EXPECT_EQ(cloud_extension("a/B.PcD"), ".pcd");
  EXPECT_FALSE(cloud_extension("a.pcd/b"));
  EXPECT_FALSE(cloud_extension(".ply"));
}

TEST_F(CloudTest, UnknownExtensionsAreAnsweredWithTheKnown) {
  file_error(make("a.e57", "x"), ".bin (KITTI), .pcd, .ply, .las", [&] { read_cloud(path("a.e57")); });
  file_error("none", ".bin (KITTI), .pcd, .ply, .las", [] { read_cloud("none"); });
}

/// What must hold of a scan whatever the file was.
void expect_valid(const Scan& scan) {
  for (const Eigen::Vector3d& p : scan.p_sensor) {
    EXPECT_TRUE(p.allFinite());
    EXPECT_NE(p, Eigen::Vector3d::Zero());
  }
  EXPECT_TRUE(scan.time_offset.empty() || scan.time_offset.size() == scan.p_sensor.size());
}

TEST_F(CloudTest, EveryTruncationIsNoticed) {
  for (const Sample& sample : samples()) {
    for (std::size_t size = 0; size < sample.bytes.size(); ++size) {
      const std::filesystem::path file = make(sample.name, sample.bytes.substr(0, size));
      // The end of these is not known: whole points of a .bin, all of a text but the last line's end.
      const bool may_read = size > 0 && (file.extension() == ".bin"
                                             ? size % 16 == 0
                                             : sample.has_text_points && size + 1 == sample.bytes.size());
      try {
        const Scan scan = read_cloud(file);
        expect_valid(scan);
        EXPECT_TRUE(may_read) << sample.name << " cut to " << size;
        EXPECT_LE(scan.p_sensor.size(), 3U);
      } catch (const FileError& error) {
        EXPECT_FALSE(may_read) << error.what();
        EXPECT_EQ(error.path(), file);
      }
    }
  }
}

TEST_F(CloudTest, ChangedBytesDoNoHarm) {
  std::mt19937 random(1);
  for (const Sample& sample : samples()) {
    for (std::size_t i = 0; i < 8 * sample.bytes.size(); ++i) {
      std::string bytes = sample.bytes;
      bytes[i / 8] = static_cast<char>(random() % 256);
      const std::filesystem::path file = make(sample.name, bytes);
      try {
        expect_valid(read_cloud(file));
      } catch (const FileError& error) {
        EXPECT_EQ(error.path(), file);
        EXPECT_EQ(std::string_view(error.what()).find('\n'), std::string_view::npos);
      }
    }
  }
}

TEST_F(CloudTest, NoiseDoesNoHarm) {
  std::mt19937 random(2);
  for (int i = 0; i < 200; ++i) {
    std::string noise(1 + random() % 300, '\0');
    for (char& c : noise) c = static_cast<char>(random() % 256);
    for (const char* name : {"a.pcd", "a.ply"}) {
      const std::filesystem::path file = make(name, noise);
      EXPECT_THROW(read_cloud(file), FileError);
    }
  }
}

/// Points of 7 m spacing about a UTM coordinate, three values each.
std::string utm_pcd(const std::string& type) {
  const std::string size = type == "4" ? "4 4 4" : "8 8 8";
  const std::vector<double> values = {691000, 4649776, 200, 691007, 4649783, 201};
  return "FIELDS x y z\nSIZE " + size + "\nTYPE F F F\nWIDTH 2\nDATA binary\n" +
         (type == "4" ? bytes_of(std::vector<float>(values.begin(), values.end())) : bytes_of(values));
}

TEST_F(CloudTest, CoordinatesTooCoarseForALeafAreNamed) {
  CloudNotes notes;
  const std::filesystem::path coarse = make("a.pcd", utm_pcd("4"));
  read_cloud(coarse, {}, &notes);
  EXPECT_EQ(notes.coordinate_step, 0.5);
  file_error(coarse, "step by 0.5 m at 4649783 m from the origin, too coarse for leaves of 0.2 m",
             [&] { check_coordinate_step(coarse, notes, 0.2); });
  const std::filesystem::path fine = make("a.pcd", utm_pcd("8"));
  read_cloud(fine, {}, &notes);
  EXPECT_EQ(notes.coordinate_step, 0);
  check_coordinate_step(fine, notes, 0.05);
  read_cloud(make("a.bin", bytes_of<float>({1, 2, 3, 0, 100, 2, 3, 0})), {}, &notes);
  EXPECT_EQ(notes.farthest_coordinate, 100);
  EXPECT_LT(notes.coordinate_step, 1e-5);
  check_coordinate_step(path("a.bin"), notes, 0.05);
}

TEST_F(CloudTest, AViewpointIsNotedAndCanBeIgnored) {
  std::string pcd = pcd_header(1, "ascii") + "1 2 3\n";
  CloudNotes notes;
  read_cloud(make("a.pcd", pcd), {}, &notes);
  EXPECT_FALSE(notes.has_viewpoint);
  pcd.replace(pcd.find("0 0 0 1 0 0 0"), 13, "5 0 0 1 0 0 0");
  EXPECT_TRUE(read_cloud(make("a.pcd", pcd), {}, &notes).T_map_sensor);
  EXPECT_TRUE(notes.has_viewpoint);
  EXPECT_FALSE(read_cloud(path("a.pcd"), {.bin_fields = {}, .ignore_viewpoint = true}, &notes).T_map_sensor);
  EXPECT_TRUE(notes.has_viewpoint);
}

class RealCloudTest : public testing::Test {
 protected:
  static std::filesystem::path data(const std::string& name) {
    const char* folder = std::getenv("EVERMAP_DATA");
    return std::filesystem::path(folder != nullptr ? folder : EVERMAP_DEFAULT_DATA) / name;
  }
  static void expect_within(const Scan& scan, double range) {
    for (const Eigen::Vector3d& p : scan.p_sensor) ASSERT_LT(p.norm(), range);
  }
};

TEST_F(RealCloudTest, VelodyneWithPaddedFields) {
  const std::filesystem::path file = data("reader_fixtures/pcd_odd/vlp16_padded_fields.pcd");
  if (!std::filesystem::exists(file)) GTEST_SKIP() << "no " << file;
  const Scan scan = read_cloud(file);
  EXPECT_EQ(scan.p_sensor.size() + scan.dropped_at_origin + scan.dropped_not_finite, 28298U);
  EXPECT_GT(scan.p_sensor.size(), 20000U);
  expect_within(scan, 150);
  EXPECT_FALSE(scan.T_map_sensor);
}

TEST_F(RealCloudTest, BinaryPcd) {
  const std::filesystem::path file = data("reader_fixtures/cdr_and_pcd/cloudini_lidar.pcd");
  if (!std::filesystem::exists(file)) GTEST_SKIP() << "no " << file;
  const Scan scan = read_cloud(file);
  EXPECT_EQ(scan.p_sensor.size() + scan.dropped_at_origin + scan.dropped_not_finite, 115385U);
  EXPECT_GT(scan.p_sensor.size(), 100000U);
  expect_within(scan, 150);
}

TEST_F(RealCloudTest, KittiScans) {
  const std::filesystem::path folder = data("kitti_redlight_standstill/scans");
  if (!std::filesystem::exists(folder)) GTEST_SKIP() << "no " << folder;
  ScanFolder source(folder);
  EXPECT_EQ(source.size(), 27U);
  const Scan scan = source.next().value();
  EXPECT_EQ(scan.p_sensor.size() + scan.dropped_at_origin, std::filesystem::file_size(source.file(0)) / 16);
  expect_within(scan, 130);
}

}  // namespace
}  // namespace evermap
