// SPDX-FileCopyrightText: 2026 the evermap authors
// SPDX-License-Identifier: BSD-3-Clause
#include <cmath>

#include "io/cloud_samples.hpp"
#include <evermap/io/detail/pcd.hpp>

namespace evermap {
namespace {

/// The header of pcd_header with one line replaced, or removed when `line` is empty; line 1 is the comment.
std::string header_with(std::size_t number, const std::string& line, const std::string& data = "ascii") {
  std::string text = pcd_header(1, data);
  std::size_t begin = 0;
  for (std::size_t i = 1; i < number; ++i) begin = text.find('\n', begin) + 1;
  return text.replace(begin, text.find('\n', begin) + 1 - begin, line.empty() ? "" : line + "\n");
}

class PcdTest : public FileTest {
 protected:
  Scan read(std::string_view bytes) { return read_pcd(make("a.pcd", bytes)); }
  FileError error(std::string_view bytes, std::string_view message) {
    const std::filesystem::path file = make("a.pcd", bytes);
    return file_error(file, message, [&] { read_pcd(file); });
  }
};

TEST_F(PcdTest, AnyOrderTypeAndCountOfFields) {
  const std::string header =
      "VERSION .7\nFIELDS _ z ring x _ y normal\nSIZE 1 8 2 4 8 1 4\nTYPE U F U I F I F\nCOUNT 3 1 1 1 1 1 "
      "3\n"
      "WIDTH 2\nHEIGHT 1\nPOINTS 2\nDATA ";
  std::string records;
  for (const int sign : {1, -1}) {
    records += "pad" + bytes_of<double>({sign * 0.125}) + bytes_of<std::uint16_t>({7}) +
               bytes_of<std::int32_t>({sign * 100000}) + bytes_of<double>({NAN}) +
               bytes_of<std::int8_t>({static_cast<std::int8_t>(sign * -5)}) + bytes_of<float>({1, 2, 3});
  }
  const std::vector<Scan> scans = {read(header + "binary\n" + records),
                                   read(header + "ascii\n9 9 9 0.125 7 100000 nan -5 1 2 3\n"
                                                 "9 9 9 -.125 7 -100000 nan 5 1 2 3")};
  for (const Scan& scan : scans) {
    ASSERT_EQ(scan.p_sensor.size(), 2U);
    EXPECT_EQ(scan.p_sensor[0], Eigen::Vector3d(100000, -5, 0.125));
    EXPECT_EQ(scan.p_sensor[1], Eigen::Vector3d(-100000, 5, -0.125));
    EXPECT_EQ(scan.dropped_not_finite, 0U) << "only coordinates and times count";
  }
}

TEST_F(PcdTest, CompressedFieldsStandInColumns) {
  const std::string header =
      "VERSION 0.7\nFIELDS normal x y z t\nSIZE 4 8 4 2 4\nTYPE F F F I U\nCOUNT 3 1 1 1 1\n"
      "WIDTH 2\nHEIGHT 1\nPOINTS 2\nDATA binary_compressed\n";
  const Scan scan =
      read(header + compressed_block(bytes_of<float>({9, 9, 9, 9, 9, 9}) + bytes_of<double>({1, 2}) +
                                     bytes_of<float>({3, 4}) + bytes_of<std::int16_t>({5, -6}) +
                                     bytes_of<std::uint32_t>({0, 1000000})));
  ASSERT_EQ(scan.p_sensor.size(), 2U);
  EXPECT_EQ(scan.p_sensor[0], Eigen::Vector3d(1, 3, 5));
  EXPECT_EQ(scan.p_sensor[1], Eigen::Vector3d(2, 4, -6));
  EXPECT_EQ(scan.time_offset, (std::vector<float>{0, 1e-3F}));
}

TEST_F(PcdTest, HeaderMayLackWhatHasADefault) {
  const Scan scan = read(
      "COLUMNS x y z\r\nSIZE 4 4 4\r\nTYPE F F F\r\n# no COUNT\r\n\r\nPOINTS 1\r\nDATA ascii\r\n1 2 3\r\n");
  EXPECT_EQ(scan.p_sensor.at(0), Eigen::Vector3d(1, 2, 3));
  EXPECT_EQ(read(header_with(10, "") + "1 2 3\n").p_sensor.size(), 1U) << "WIDTH without POINTS";
}

TEST_F(PcdTest, OrganizedCloudHasWidthTimesHeightPoints) {
  const std::string header =
      "FIELDS x y z\nSIZE 4 4 4\nTYPE F F F\nWIDTH 2\nHEIGHT 2\nPOINTS 4\nDATA binary\n";
  const Scan scan = read(header + bytes_of<float>({1, 2, 3, kNaN, kNaN, kNaN, 0, 0, 0, 4, 5, 6}));
  EXPECT_EQ(scan.p_sensor.size(), 2U);
  EXPECT_EQ(scan.dropped_not_finite, 1U);
  EXPECT_EQ(scan.dropped_at_origin, 1U);
}

TEST_F(PcdTest, NoPointsAreNoError) {
  for (const char* data : {"ascii", "binary", "binary_compressed"}) {
    EXPECT_TRUE(read(pcd_header(0, data)).p_sensor.empty()) << data;
  }
}

TEST_F(PcdTest, PaddingBehindBinaryPointsIsIgnored) {
  const Scan scan = read(pcd_header(1, "binary") + bytes_of<float>({1, 2, 3}) + std::string(4096, '\0'));
  EXPECT_EQ(scan.p_sensor.size(), 1U);
}

TEST_F(PcdTest, ViewpointIsTheSensorPose) {
  EXPECT_FALSE(read(pcd_header(1, "ascii") + "1 2 3\n").T_map_sensor);
  // A quarter turn about z; the norm of the quaternion is 0.9998.
  const Scan scan = read(header_with(9, "VIEWPOINT 10 20 -1.5 0.707 0 0 0.707") + "1 2 3\n");
  ASSERT_TRUE(scan.T_map_sensor);
  const Eigen::Vector3d p_map = *scan.T_map_sensor * scan.p_sensor.at(0);
  EXPECT_LT((p_map - Eigen::Vector3d(8, 21, 1.5)).norm(), 1e-12);
}

TEST_F(PcdTest, FieldsOfNoValuesTakeNoPlace) {
  const std::string header =
      "FIELDS X _ Y Z padding\nSIZE 4 1 4 4 8\nTYPE F U F F U\nCOUNT 1 0 1 1 0\nWIDTH 2\nPOINTS 2\n";
  for (const Scan& scan : {read(header + "DATA ascii\n1 2 3\n4 5 6\n"),
                           read(header + "DATA binary\n" + bytes_of<float>({1, 2, 3, 4, 5, 6}))}) {
    ASSERT_EQ(scan.p_sensor.size(), 2U);
    EXPECT_EQ(scan.p_sensor[1], Eigen::Vector3d(4, 5, 6));
  }
}

TEST_F(PcdTest, NamesInUpperCaseMeanTheSameUnlessBothAreThere) {
  const std::string header =
      "FIELDS x X Y Z Time\nSIZE 4 4 4 4 4\nTYPE F F F F F\nWIDTH 2\nPOINTS 2\nDATA ascii\n";
  const Scan scan = read(header + "1 9 2 3 0.1\n1 9 2 3 0.2\n");
  EXPECT_EQ(scan.p_sensor.at(0), Eigen::Vector3d(1, 2, 3));
  EXPECT_EQ(scan.time_offset.size(), 2U);
  error("FIELDS X x x y z\nSIZE 4 4 4 4 4\nTYPE F F F F F\nWIDTH 1\nDATA ascii\n1 2 3 4 5\n",
        "more than one value named x");
}

TEST_F(PcdTest, UnitsOfTimesAreFoundFromTheirSpan) {
  const std::string p = bytes_of<float>({1, 2, 3});
  const auto offset = [&](const std::string& name, const std::string& size, const std::string& type,
                          const std::string& first, const std::string& last) {
    CloudNotes notes;
    const Scan scan =
        read_pcd(make("a.pcd", "FIELDS x y z " + name + "\nSIZE 4 4 4 " + size + "\nTYPE F F F " + type +
                                   "\nWIDTH 2\nDATA binary\n" + p + first + p + last),
                 &notes);
    EXPECT_EQ(notes.time.value().field, name);
    EXPECT_NEAR(notes.time.value().span, 0.1, 1e-6);
    EXPECT_NE(notes.time->describe().find("0.1 s from first to last"), std::string::npos);
    return scan.time_offset.at(1);
  };
  const auto doubles = [](double value) { return bytes_of<double>({value}); };
  const auto floats = [](float value) { return bytes_of<float>({value}); };
  const auto longs = [](std::uint64_t value) { return bytes_of<std::uint64_t>({value}); };
  EXPECT_NEAR(offset("timestamp", "8", "F", doubles(1.7e18), doubles(1.7e18 + 1e8)), 0.1, 1e-6);  // Livox
  EXPECT_NEAR(offset("timestamp", "8", "F", doubles(1.7e9), doubles(1.7e9 + 0.1)), 0.1, 1e-6);    // RoboSense
  EXPECT_NEAR(offset("timeStamp", "4", "F", floats(-100), floats(0)), 0.1, 1e-6);  // ms to the end
  EXPECT_NEAR(offset("time_stamp", "4", "F", floats(0), floats(1e5F)), 0.1, 1e-6);
  EXPECT_NEAR(offset("time", "4", "F", floats(-0.1F), floats(0)), 0.1, 1e-6);  // Velodyne
  EXPECT_NEAR(offset("t", "8", "U", longs(1'700'000'000'000'000'000), longs(1'700'000'000'100'000'000)), 0.1,
              1e-6);
  EXPECT_NEAR(offset("offset_time", "8", "U", longs(7), longs(100'007)), 0.1, 1e-6);
}

TEST_F(PcdTest, TimesCountFromTheEarliestPoint) {
  const auto times = [&](const std::string& name, const std::string& size, const std::string& type,
                         const std::string& bytes) {
    return read("FIELDS x y z " + name + "\nSIZE 4 4 4 " + size + "\nTYPE F F F " + type +
                "\nWIDTH 2\nHEIGHT 1\nPOINTS 2\nDATA binary\n" + bytes)
        .time_offset;
  };
  const std::string p = bytes_of<float>({1, 2, 3});
  const std::vector<float> expected = {0.5F, 0};
  for (const char* name : {"t", "offset_time"}) {
    EXPECT_EQ(
        times(name, "4", "U",
              p + bytes_of<std::uint32_t>({4'000'000'000U}) + p + bytes_of<std::uint32_t>({3'500'000'000U})),
        expected);
  }
  for (const char* name : {"time", "timestamp"}) {
    EXPECT_EQ(times(name, "4", "F", p + bytes_of<float>({0.25F}) + p + bytes_of<float>({-0.25F})), expected);
  }
  EXPECT_EQ(times("timestamp", "8", "F", p + bytes_of<double>({1.7e9 + 0.5}) + p + bytes_of<double>({1.7e9})),
            expected);
  EXPECT_TRUE(times("intensity", "4", "F", p + bytes_of<float>({1}) + p + bytes_of<float>({2})).empty());
}

TEST_F(PcdTest, DroppedPointsHaveNoTime) {
  const std::string header = "FIELDS x y z time\nSIZE 4 4 4 4\nTYPE F F F F\nWIDTH 4\nPOINTS 4\nDATA ascii\n";
  const Scan scan = read(header + "0 0 0 -9\n1 1 1 2\nnan 1 1 0\n1 1 1 nan\n");
  EXPECT_EQ(scan.p_sensor.size(), 1U);
  EXPECT_EQ(scan.time_offset, std::vector<float>{0});
  EXPECT_EQ(scan.dropped_at_origin, 1U);
  EXPECT_EQ(scan.dropped_not_finite, 2U);
}

TEST_F(PcdTest, BadHeaderLinesAreNamed) {
  const std::string point = "1 2 3\n";
  expect_at_line(error(header_with(2, "hello world") + point, "'hello' is no keyword"), 2);
  expect_at_line(error(header_with(2, "FIELDS x") + point, "a second FIELDS line; the first is line 2"), 3);
  expect_at_line(error(header_with(4, "SIZE 4 4") + point, "SIZE has 2 values for 3 FIELDS"), 4);
  expect_at_line(error(header_with(4, "SIZE 4 4 3") + point, "'F' of SIZE '3' is no type"), 5);
  expect_at_line(error(header_with(4, "SIZE 4 4 -4") + point, "'-4'"), 5);
  expect_at_line(error(header_with(5, "TYPE F F D") + point, "'D' of SIZE '4' is no type"), 5);
  expect_at_line(error(header_with(6, "COUNT 1 1 -1") + point, "'-1' is no number of values"), 6);
  expect_at_line(error(header_with(6, "COUNT 1 1 4611686018427387905") + point, "larger than any file"), 6);
  expect_at_line(error(header_with(7, "WIDTH -1") + point, "WIDTH '-1' is no count"), 7);
  expect_at_line(error(header_with(7, "WIDTH 1 1") + point, "WIDTH needs one number"), 7);
  expect_at_line(error(header_with(8, "HEIGHT 2") + point, "POINTS does not agree"), 10);
  expect_at_line(error(header_with(9, "VIEWPOINT 0 0 0") + point, "VIEWPOINT needs seven"), 9);
  expect_at_line(error(header_with(9, "VIEWPOINT 0 0 0 0 0 0 0") + point, "norm is not 1"), 9);
  expect_at_line(error(header_with(9, "VIEWPOINT 0 0 nan 1 0 0 0") + point, "'nan' is no finite number"), 9);
  expect_at_line(error(header_with(10, "POINTS 99999999999999999999") + point, "is no count"), 10);
  expect_at_line(error(header_with(11, "DATA morse") + point, "DATA must be"), 11);
  error(header_with(4, "") + point, "has no SIZE line");
  error(header_with(3, "FIELDS x y w") + point, "has no field z");
  error(header_with(3, "FIELDS x y y") + point, "more than one value named y");
  error(header_with(6, "COUNT 1 1 2") + "1 2 3 4\n", "more than one value named z");
}

TEST_F(PcdTest, SizesThatOverflowAreRefused) {
  const std::string product = "FIELDS x y z\nSIZE 4 4 4\nTYPE F F F\nWIDTH 4294967296\nHEIGHT 4294967296\n";
  expect_at_line(error(product + "DATA binary\n", "WIDTH does not agree"), 4);
  expect_at_line(error(product + "POINTS 0\nDATA binary\n", "POINTS does not agree"), 6);
}

TEST_F(PcdTest, PointsThatAreNotThereTakeNoMemory) {
  const std::size_t lie = 1'000'000'000'000;
  const std::string p = bytes_of<float>({1, 2, 3});
  const std::size_t binary_begin = pcd_header(lie, "binary").size();
  expect_at_byte(error(pcd_header(lie, "binary") + p + "12345", "ends inside point 1 of 1000000000000"),
                 binary_begin + 12);
  expect_at_line(error(pcd_header(lie, "ascii") + "1 2 3\n", "room for 1 at most"), 11);
  expect_at_byte(error(pcd_header(lie, "binary_compressed") + compressed_block(p), "another number"),
                 pcd_header(lie, "binary_compressed").size() + 4);
}

TEST_F(PcdTest, TextLinesThatAreNoPointsAreNamed) {
  const std::string header = pcd_header(2, "ascii");
  expect_at_line(error(header + "1 2 3\n\n4 5\n 7 8", "has 2 values instead of 3"), 14);
  expect_at_line(error(header + "1 2 3\n4 5 6 7\n", "has 4 values instead of 3"), 13);
  expect_at_line(error(header + "1 2 3\n4 5 6x\n", "'6x' is no number"), 13);
  expect_at_line(error(header + "1 2 3\n4 5 6\n7 8 9\n", "more points than the header says"), 14);
  const std::string short_of_one = header + "1.25 2.25 3.25\n";
  expect_at_byte(error(short_of_one, "ends after 1 of 2 points"), short_of_one.size());
}

TEST_F(PcdTest, CompressedSizesThatLieAreRefused) {
  const std::string header = pcd_header(1, "binary_compressed");
  const std::string columns = bytes_of<float>({1, 2, 3});
  const std::string stream = lzf_literals(columns);
  const auto with_sizes = [&](std::uint32_t compressed, std::uint32_t size) {
    return header + bytes_of<std::uint32_t>({compressed, size}) + stream;
  };
  EXPECT_EQ(read(with_sizes(13, 12)).p_sensor.size(), 1U);
  expect_at_byte(error(header + "1234567", "ends inside the sizes"), header.size());
  expect_at_byte(error(with_sizes(14, 12), "promises 14 compressed bytes, 13 follow"), header.size());
  expect_at_byte(error(with_sizes(0xFFFFFFFF, 12), "promises 4294967295"), header.size());
  expect_at_byte(error(with_sizes(13, 13), "another number"), header.size() + 4);
  expect_at_byte(error(with_sizes(13, 0), "another number"), header.size() + 4);
  expect_at_byte(error(with_sizes(12, 12), "data is damaged"), header.size() + 8);
  const std::string large = pcd_header(100'000'000, "binary_compressed");
  expect_at_byte(error(large + bytes_of<std::uint32_t>({13, 1'200'000'000}) + stream, "can hold"),
                 large.size() + 4);
  std::string damaged = with_sizes(13, 12);
  damaged[header.size() + 8] = '\x20';
  expect_at_byte(error(damaged, "data is damaged"), header.size() + 8);
}

TEST_F(PcdTest, WhatIsNoPcdIsRefused) {
  error("", "is empty");
  expect_at_line(error("ply\nformat ascii 1.0\n", "is this a PCD file?"), 1);
  expect_at_line(error(std::string(100000, '\xFF'), "is no keyword"), 1);
  expect_at_byte(error("VERSION 0.7\nFIELDS x y z\n", "ends before the DATA line"), 25);
  file_error(path("none"), "No such file", [&] { read_pcd(path("none")); });
  file_error(folder_, "is a folder", [&] { read_pcd(folder_); });
}

TEST_F(PcdTest, WrittenTableIsReadBack) {
  using Type = PointTable::Type;
  const PointTable table = {
      {{"occupancy", Type::kFloat32}, {"x", Type::kFloat64}, {"y", Type::kFloat64}, {"z", Type::kFloat32}},
      {0.5, 1234567.0625, -1e6 - 1e-6, 3.5, 0.25, 1, 2, 3}};
  write_pcd(path("a.pcd"), table);
  const Scan scan = read_pcd(path("a.pcd"));
  ASSERT_EQ(scan.p_sensor.size(), 2U);
  EXPECT_EQ(scan.p_sensor[0], Eigen::Vector3d(1234567.0625, -1e6 - 1e-6, 3.5));
  EXPECT_EQ(scan.p_sensor[1], Eigen::Vector3d(1, 2, 3));
  EXPECT_FALSE(scan.T_map_sensor);
  EXPECT_EQ(files_in_folder(), 1U);
}

TEST_F(PcdTest, MalformedTablesAreNotWritten) {
  EXPECT_THROW(write_pcd(path("a.pcd"), {}), std::invalid_argument);
  EXPECT_THROW(write_pcd(path("a.pcd"), {{{""}}, {}}), std::invalid_argument);
  EXPECT_THROW(write_pcd(path("a.pcd"), {{{"two words"}}, {}}), std::invalid_argument);
  EXPECT_THROW(write_pcd(path("a.pcd"), {{{"a\nb"}}, {}}), std::invalid_argument);
  EXPECT_THROW(write_pcd(path("a.pcd"), {{{"x"}, {"y"}}, {1, 2, 3}}), std::invalid_argument);
  file_error(path("none/a.pcd"), "No such file", [&] { write_pcd(path("none/a.pcd"), {{{"x"}}, {1}}); });
  EXPECT_EQ(files_in_folder(), 0U);
}

/// What a megabyte may ask for does not depend on what its points are made of.
TEST_F(PcdTest, CompressedDataThatExpandsBeyondReasonIsRefused) {
  // Zeros only, as short as LZF can say them: one literal, then copies of 264 bytes.
  const std::size_t points = 12'000'000;
  std::string stream("\0\0", 2);
  for (std::size_t size = 1; size + 264 <= 3 * points; size += 264) stream += std::string("\xE0\xFF\0", 3);
  const std::size_t rest = (3 * points - 1) % 264;
  ASSERT_GE(rest, 9U);
  stream += '\xE0';
  stream += static_cast<char>(rest - 9);
  stream += '\0';
  const std::string header =
      "FIELDS x y z\nSIZE 1 1 1\nTYPE U U U\nWIDTH " + std::to_string(points) + "\nDATA binary_compressed\n";
  const std::string sizes = bytes_of<std::uint32_t>(
      {static_cast<std::uint32_t>(stream.size()), static_cast<std::uint32_t>(3 * points)});
  expect_at_byte(error(header + sizes + stream, "expands to 12000000 points"), header.size() + 4);
}

}  // namespace
}  // namespace evermap
