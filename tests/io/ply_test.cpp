// SPDX-FileCopyrightText: 2026 the evermap authors
// SPDX-License-Identifier: BSD-3-Clause
#include "io/cloud_samples.hpp"
#include <evermap/io/detail/ply.hpp>

namespace evermap {
namespace {

const std::string kXyz = "property float x\nproperty float y\nproperty float z\n";

std::string ply_header(const std::string& elements, const std::string& format = "ascii") {
  return "ply\nformat " + format + " 1.0\n" + elements + "end_header\n";
}

class PlyTest : public FileTest {
 protected:
  Scan read(std::string_view bytes) { return read_ply(make("a.ply", bytes)); }
  FileError error(std::string_view bytes, std::string_view message) {
    const std::filesystem::path file = make("a.ply", bytes);
    return file_error(file, message, [&] { read_ply(file); });
  }
};

/// One vertex with a property of every type, y and z among them, between elements that are skipped.
TEST_F(PlyTest, AnyTypeOrderAndPlaceOfTheVertices) {
  const std::string elements =
      "comment before\nelement camera 1\nproperty double focus\nproperty uint8 id\n"
      "element strip 2\nproperty list uchar int a\nproperty short b\nproperty list uint16 float64 c\n"
      "element nothing 1000000000000\n"
      "obj_info in between\n"
      "element vertex 2\nproperty uchar red\nproperty int8 z\nproperty ushort u\nproperty float32 x\n"
      "property int i\nproperty uint t\nproperty double y\nproperty int16 s\n"
      "element face 9\nproperty list uchar int vertex_indices\n";
  const auto binary = [](std::endian order) {
    std::string bytes = bytes_of<double>({0.5}, order) + "\x01";
    bytes += "\x02" + bytes_of<std::int32_t>({1, 2}, order) + bytes_of<std::int16_t>({3}, order) +
             bytes_of<std::uint16_t>({1}, order) + bytes_of<double>({4}, order);
    bytes += std::string(1, '\0') + bytes_of<std::int16_t>({3}, order) + bytes_of<std::uint16_t>({0}, order);
    for (const int sign : {1, -1}) {
      bytes += "\xFF" + bytes_of<std::int8_t>({static_cast<std::int8_t>(3 * sign)}, order) +
               bytes_of<std::uint16_t>({500}, order) + bytes_of<float>({sign > 0 ? 1.5F : -1.5F}, order) +
               bytes_of<std::int32_t>({-1}, order) + bytes_of<std::uint32_t>({7U + sign}, order) +
               bytes_of<double>({1e6 + 1e-3 * sign}, order) + bytes_of<std::int16_t>({-2}, order);
    }
    return bytes;
  };
  const std::string text =
      "0.5 1\n2 1 2 3 1 4\n0 3 0\n255 3 500 1.5 -1 8 1000000.001 -2\n255 -3 500 -1.5 -1 6 999999.999 -2\n";
  const std::vector<Scan> scans = {
      read(ply_header(elements) + text),
      read(ply_header(elements, "binary_little_endian") + binary(std::endian::little)),
      read(ply_header(elements, "binary_big_endian") + binary(std::endian::big))};
  for (const Scan& scan : scans) {
    ASSERT_EQ(scan.p_sensor.size(), 2U);
    EXPECT_EQ(scan.p_sensor[0], Eigen::Vector3d(1.5, 1e6 + 1e-3, 3));
    EXPECT_EQ(scan.p_sensor[1], Eigen::Vector3d(-1.5, 1e6 - 1e-3, -3));
    EXPECT_EQ(scan.time_offset, (std::vector<float>{2e-9F, 0}));
  }
}

TEST_F(PlyTest, LinesMayEndAsOnWindows) {
  const Scan scan = read(
      "ply\r\nformat binary_little_endian 1.0\r\nelement vertex 1\r\nproperty float x\r\n"
      "property float y\r\nproperty float z\r\nend_header\r\n" +
      bytes_of<float>({1, 2, 3}));
  EXPECT_EQ(scan.p_sensor.at(0), Eigen::Vector3d(1, 2, 3));
}

TEST_F(PlyTest, PointsWithoutAPlaceAreDroppedAndCounted) {
  const Scan scan = read(ply_header("element vertex 4\n" + kXyz) + "nan 1 1\n1 -inf 1\n0 0 -0\n1 2 3\n");
  EXPECT_EQ(scan.p_sensor.size(), 1U);
  EXPECT_EQ(scan.dropped_not_finite, 2U);
  EXPECT_EQ(scan.dropped_at_origin, 1U);
}

TEST_F(PlyTest, BadHeaderLinesAreNamed) {
  const std::string rest = "element vertex 1\n" + kXyz + "end_header\n1 2 3\n";
  expect_at_line(error("ply\nformat ascii 2.0\n" + rest, "version of a PLY file must be 1.0"), 2);
  expect_at_line(error("ply\nformat text 1.0\n" + rest, "'text' is no PLY format"), 2);
  expect_at_line(error("ply\n" + rest, "no format line"), 6);
  expect_at_line(error("ply\nproperty float x\n" + rest, "before the first element"), 2);
  expect_at_line(error("ply\nhello\n" + rest, "'hello' is no keyword"), 2);
  expect_at_line(error(ply_header("element vertex -1\n" + kXyz), "'-1' is no count"), 3);
  expect_at_line(error(ply_header("element vertex\n" + kXyz), "'' is no count"), 3);
  expect_at_line(error(ply_header("element vertex 18446744073709551616\n" + kXyz), "is no count"), 3);
  expect_at_line(error(ply_header("element vertex 1\nproperty real x\n"), "'real' is no type"), 4);
  expect_at_line(error(ply_header("element vertex 1\nproperty float\n"), "without a name"), 4);
  expect_at_line(error(ply_header("element face 1\nproperty list float int i\n"), "cannot count"), 4);
  error(ply_header("element vertex 1\nproperty float x\nproperty float y\n") + "1 2\n", "has no field z");
  error(ply_header("element vertex 1\nproperty float x\n" + kXyz) + "1 1 2 3\n",
        "more than one value named x");
  error(ply_header("element vertex 1\nproperty list uchar int i\n" + kXyz) + "0 1 2 3\n", "have a list, 'i'");
  error(ply_header("element point 1\n" + kXyz) + "1 2 3\n", "has no vertex element");
  error(ply_header(""), "has no vertex element");
}

TEST_F(PlyTest, PointsThatAreNotThereTakeNoMemory) {
  const std::string elements = "element vertex 1000000000000\n" + kXyz;
  expect_at_line(error(ply_header(elements) + "1 2 3\n", "room for 1 at most"), 7);
  const std::string binary = ply_header(elements, "binary_little_endian");
  expect_at_byte(error(binary + bytes_of<float>({1, 2, 3, 4}), "ends inside point 1"), binary.size() + 12);
}

TEST_F(PlyTest, ElementsBeforeTheVerticesThatLieAreRefused) {
  const std::string vertex = "element vertex 1\n" + kXyz;
  const std::string p = bytes_of<float>({1, 2, 3});
  const auto binary = [&](const std::string& element) {
    return ply_header(element + vertex, "binary_little_endian");
  };
  std::string header = binary("element a 1000000000000\nproperty int i\n");
  expect_at_byte(error(header + p, "ends inside the data of element 'a'"), header.size());
  header = binary("element a 4611686018427387905\nproperty int i\n");
  expect_at_byte(error(header + p, "ends inside the data of element 'a'"), header.size());
  header = binary("element a 1000000000000\nproperty list uchar int i\n");
  expect_at_byte(error(header + std::string(5, '\0'), "ends inside the data"), header.size() + 5);
  header = binary("element a 1\nproperty list int int i\n");
  expect_at_byte(error(header + bytes_of<std::int32_t>({-1}) + p, "list of negative length"), header.size());
  expect_at_byte(error(header + bytes_of<std::int32_t>({0x7FFFFFFF}) + p, "ends inside the data"),
                 header.size() + 4);
  error(ply_header("element a 1000000000000\nproperty int i\n" + vertex) + "1\n1 2 3\n",
        "ends inside the data of element 'a'");
}

TEST_F(PlyTest, WhatIsNoPlyIsRefused) {
  error("", "is empty");
  expect_at_byte(error("plywood\n", "is this a PLY file?"), 0);
  expect_at_byte(error("ply\nformat ascii 1.0\n", "ends before the end_header"), 21);
  file_error(path("none"), "No such file", [&] { read_ply(path("none")); });
  file_error(folder_, "is a folder", [&] { read_ply(folder_); });
}

TEST_F(PlyTest, WrittenTableIsReadBack) {
  using Type = PointTable::Type;
  const PointTable table = {
      {{"z", Type::kFloat32}, {"y", Type::kFloat64}, {"x", Type::kFloat64}, {"occupancy", Type::kFloat32}},
      {3.5, -1e6 - 1e-6, 1234567.0625, 0.5, 3, 2, 1, 0.25}};
  write_ply(path("a.ply"), table);
  const Scan scan = read_ply(path("a.ply"));
  ASSERT_EQ(scan.p_sensor.size(), 2U);
  EXPECT_EQ(scan.p_sensor[0], Eigen::Vector3d(1234567.0625, -1e6 - 1e-6, 3.5));
  EXPECT_EQ(scan.p_sensor[1], Eigen::Vector3d(1, 2, 3));
  EXPECT_EQ(files_in_folder(), 1U);
}

TEST_F(PlyTest, MalformedTablesAreNotWritten) {
  EXPECT_THROW(write_ply(path("a.ply"), {}), std::invalid_argument);
  EXPECT_EQ(files_in_folder(), 0U);
}

}  // namespace
}  // namespace evermap
