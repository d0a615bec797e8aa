// SPDX-FileCopyrightText: 2026 the evermap authors
// SPDX-License-Identifier: BSD-3-Clause
#include "files/file_fixture.hpp"
#include <evermap/io/scan_source.hpp>

namespace evermap {
namespace {

class ScanSourceTest : public FileTest {
 protected:
  void make_scan(const std::string& name, float x) { make(name, bytes_of<float>({x, 0, 0, 0})); }
};

TEST_F(ScanSourceTest, FolderIsReadInTheOrderOfNames) {
  make_scan("000010.bin", 10);
  make_scan("000002.bin", 2);
  make_scan("000001.BIN", 1);
  make("times.txt", "not a scan");
  make("._000001.bin", "what an archiver left");
  make("000003.pcd.bak", "not a scan");
  std::filesystem::create_directory(path("000004.bin"));
  ScanSource source(folder_);
  ASSERT_EQ(source.size(), 3U);
  EXPECT_EQ(source.file(0), path("000001.BIN"));
  for (const double x : {1.0, 2.0, 10.0}) {
    const std::optional<Scan> scan = source.next();
    ASSERT_TRUE(scan);
    EXPECT_EQ(scan->p_sensor.at(0).x(), x);
  }
  EXPECT_FALSE(source.next());
  EXPECT_FALSE(source.next());
}

TEST_F(ScanSourceTest, OneFileIsASequenceOfOne) {
  make_scan("a.bin", 7);
  ScanSource source(path("a.bin"));
  EXPECT_EQ(source.size(), 1U);
  EXPECT_EQ(source.next().value().p_sensor.at(0).x(), 7);
  EXPECT_FALSE(source.next());
}

TEST_F(ScanSourceTest, MixedFormatsAreNamed) {
  make_scan("a.bin", 1);
  make_scan("b.bin", 1);
  make("c.pcd", "whatever");
  const FileError error = file_error(folder_, "mixes formats", [&] { ScanSource source(folder_); });
  EXPECT_NE(std::string(error.what()).find("a.bin"), std::string::npos);
  EXPECT_NE(std::string(error.what()).find("c.pcd"), std::string::npos);
}

TEST_F(ScanSourceTest, WhereThereIsNoScanIsRefused) {
  file_error(folder_, "holds no scan", [&] { ScanSource source(folder_); });
  file_error(make("a.las", "x"), ".bin (KITTI), .pcd and .ply", [&] { ScanSource source(path("a.las")); });
  file_error(path("none"), "No such file", [&] { ScanSource source(path("none")); });
}

TEST_F(ScanSourceTest, DamageIsReportedWhenItsScanIsDue) {
  make_scan("a.bin", 1);
  make("b.bin", "short");
  make_scan("c.bin", 3);
  ScanSource source(folder_);
  EXPECT_TRUE(source.next());
  expect_at_byte(file_error(path("b.bin"), "the last point", [&] { source.next(); }), 0);
  EXPECT_EQ(source.next().value().p_sensor.at(0).x(), 3);
}

}  // namespace
}  // namespace evermap
