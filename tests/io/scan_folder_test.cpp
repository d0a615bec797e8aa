// SPDX-FileCopyrightText: 2026 the evermap authors
// SPDX-License-Identifier: BSD-3-Clause
#include "files/file_fixture.hpp"
#include <evermap/io/detail/scan_folder.hpp>

namespace evermap {
namespace {

class ScanFolderTest : public FileTest {
 protected:
  void make_scan(const std::string& name, float x) { make(name, bytes_of<float>({x, 0, 0, 0})); }
};

TEST_F(ScanFolderTest, FolderIsReadInTheOrderOfNames) {
  make_scan("000010.bin", 10);
  make_scan("000002.bin", 2);
  make_scan("000001.BIN", 1);
  make("times.txt", "not a scan");
  make("._000001.bin", "what an archiver left");
  make("000003.pcd.bak", "not a scan");
  std::filesystem::create_directory(path("000004.bin"));
  ScanFolder source(folder_);
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

TEST_F(ScanFolderTest, NumbersInNamesAreCounted) {
  const auto order = [&](const std::vector<std::string>& sorted) {
    std::filesystem::remove_all(folder_);
    std::filesystem::create_directory(folder_);
    for (auto name = sorted.rbegin(); name != sorted.rend(); ++name) make_scan(*name, 1);
    std::vector<std::string> names;
    const ScanFolder source(folder_);
    for (std::size_t i = 0; i < source.size(); ++i) names.push_back(source.file(i).filename().string());
    EXPECT_EQ(names, sorted);
  };
  order({"0.bin", "1.bin", "2.bin", "9.bin", "10.bin", "11.bin", "59.bin", "100.bin"});
  order({"000000.bin", "000001.bin", "000010.bin"});
  order({"a_2_9a.bin", "a_2_10.bin", "a_10_1.bin", "b_1_1.bin"});
  order({"1305031102.175.bin", "1305031102.2.bin", "1305031102.25.bin", "1305031110.1.bin",
         "13050311020.0.bin"});
  order({"1700000000000000000.bin", "1700000000000000001.bin", "17000000000000000000.bin"});
  order({"01.bin", "1.bin", "02.bin"});
  order({"scan.bin", "scan1.bin", "scan2.bin"});
}

TEST_F(ScanFolderTest, AFormatThatIsNamedChoosesFilesOrReadsThemWhateverTheirNames) {
  make_scan("1.bin", 1);
  make("1.pcd", "another format");
  file_error(folder_, "choose one by --format", [&] { ScanFolder{folder_}; });
  ScanFolder chosen(folder_, {.format = ".bin"});
  ASSERT_EQ(chosen.size(), 1U);
  EXPECT_EQ(chosen.next()->p_sensor.at(0).x(), 1);

  std::filesystem::remove_all(folder_);
  std::filesystem::create_directory(folder_);
  make_scan("10.lidar", 10);
  make_scan("9.lidar", 9);
  file_error(folder_, "holds no scan", [&] { ScanFolder{folder_}; });
  ScanFolder named(folder_, {.format = ".bin"});
  ASSERT_EQ(named.size(), 2U);
  EXPECT_EQ(named.next()->p_sensor.at(0).x(), 9);
  EXPECT_EQ(read_cloud(path("10.lidar"), {.format = ".bin"}).p_sensor.at(0).x(), 10);
}

TEST_F(ScanFolderTest, CompressedScansHaveTheOrderOfTheirTimes) {
  make("10.25.bin.gz", "x");
  make("10.5.bin.gz", "x");
  make("9.1.bin.gz", "x");
  const ScanFolder source(folder_);
  ASSERT_EQ(source.size(), 3U);
  EXPECT_EQ(source.file(0), path("9.1.bin.gz"));
  EXPECT_EQ(source.file(1), path("10.25.bin.gz"));
  make_scan("9.1.bin", 1);
  file_error(folder_, "mixes formats", [&] { ScanFolder mixed(folder_); });
}

TEST_F(ScanFolderTest, OptionsReachTheReader) {
  make("a.bin", bytes_of<float>({1, 2, 3, 0, 0, 4, 5, 6, 0, 0}));
  ScanFolder source(folder_, {.bin_fields = 5});
  EXPECT_EQ(source.next().value().p_sensor.size(), 2U);
  EXPECT_EQ(source.notes().bin_fields, 5U);
}

TEST_F(ScanFolderTest, OneFileIsASequenceOfOne) {
  make_scan("a.bin", 7);
  ScanFolder source(path("a.bin"));
  EXPECT_EQ(source.size(), 1U);
  EXPECT_EQ(source.next().value().p_sensor.at(0).x(), 7);
  EXPECT_FALSE(source.next());
}

TEST_F(ScanFolderTest, MixedFormatsAreNamed) {
  make_scan("a.bin", 1);
  make_scan("b.bin", 1);
  make("c.pcd", "whatever");
  const FileError error = file_error(folder_, "mixes formats", [&] { ScanFolder source(folder_); });
  EXPECT_NE(std::string(error.what()).find("a.bin"), std::string::npos);
  EXPECT_NE(std::string(error.what()).find("c.pcd"), std::string::npos);
}

TEST_F(ScanFolderTest, WhereThereIsNoScanIsRefused) {
  file_error(folder_, "holds no scan", [&] { ScanFolder source(folder_); });
  file_error(make("a.e57", "x"), ".bin (KITTI), .pcd, .ply, .las", [&] { ScanFolder source(path("a.e57")); });
  file_error(path("none"), "No such file", [&] { ScanFolder source(path("none")); });
}

TEST_F(ScanFolderTest, DamageIsReportedWhenItsScanIsDue) {
  make_scan("a.bin", 1);
  make("b.bin", "short");
  make_scan("c.bin", 3);
  ScanFolder source(folder_);
  EXPECT_TRUE(source.next());
  expect_at_byte(file_error(path("b.bin"), "the last point", [&] { source.next(); }), 0);
  EXPECT_EQ(source.next().value().p_sensor.at(0).x(), 3);
}

}  // namespace
}  // namespace evermap
