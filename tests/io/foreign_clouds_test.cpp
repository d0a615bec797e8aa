// SPDX-FileCopyrightText: 2026 the evermap authors
// SPDX-License-Identifier: BSD-3-Clause
// Clouds as other programs write them: LAS, NumPy, text.
#include "files/file_fixture.hpp"
#include <evermap/io/cloud.hpp>
#include <evermap/io/detail/scan_folder.hpp>

namespace evermap {
namespace {

using Points = std::vector<Eigen::Vector3d>;

class ForeignClouds : public FileTest {
 protected:
  Points read(const std::string& name, const std::string& bytes) {
    return read_cloud(make(name, bytes)).p_sensor;
  }
};

/// A LAS file of points at 0.001 m steps from 400000, 5000000, 0.
std::string las(std::uint8_t minor, std::uint8_t format,
                const std::vector<std::array<std::int32_t, 3>>& points) {
  const bool is_14 = minor >= 4;
  const std::size_t size = is_14 ? 375 : 227;
  std::string header(size, '\0');
  const auto put = [&](std::size_t at, const std::string& bytes) { header.replace(at, bytes.size(), bytes); };
  const auto count = static_cast<std::uint32_t>(points.size());
  put(0, "LASF");
  put(24, bytes_of<std::uint8_t>({1, minor}));
  put(94, bytes_of<std::uint16_t>({static_cast<std::uint16_t>(size)}));
  put(96,
      bytes_of<std::uint32_t>({static_cast<std::uint32_t>(size + 10)}));  // behind a record that is skipped
  put(104, bytes_of<std::uint8_t>({format}));
  put(105, bytes_of<std::uint16_t>({20}));
  if (!is_14) put(107, bytes_of<std::uint32_t>({count}));
  put(131, bytes_of<double>({0.001, 0.001, 0.001, 400000, 5000000, 0}));
  if (is_14) put(247, bytes_of<std::uint64_t>({count}));
  std::string bytes = header + std::string(10, 'v');
  for (const auto& point : points)
    bytes += bytes_of<std::int32_t>({point[0], point[1], point[2]}) + std::string(8, 'p');
  return bytes;
}

TEST_F(ForeignClouds, LasIsScaledAndShifted) {
  for (const std::uint8_t minor : std::vector<std::uint8_t>{2, 3, 4}) {
    const Points points = read("a.las", las(minor, 1, {{1000, 2000, -3000}, {4, 5, 6}}));
    ASSERT_EQ(points.size(), 2U);
    EXPECT_TRUE(points[0].isApprox(Eigen::Vector3d(400001, 5000002, -3), 1e-12));
    EXPECT_TRUE(points[1].isApprox(Eigen::Vector3d(400000.004, 5000000.005, 0.006), 1e-12));
  }
}

TEST_F(ForeignClouds, DamagedAndCompressedLasIsRefused) {
  const std::string whole = las(2, 1, {{1, 2, 3}, {4, 5, 6}});
  for (std::size_t size = 1; size < whole.size(); ++size)
    file_error(path("cut.las"), "", [&] { read("cut.las", whole.substr(0, size)); });
  expect_at_byte(file_error(path("cut.las"), "ends inside point 1",
                            [&] { read("cut.las", whole.substr(0, whole.size() - 1)); }),
                 whole.size() - 20);
  file_error(path("a.laz"), "is compressed (LAZ)", [&] { read("a.laz", las(2, 129, {{1, 2, 3}})); });
}

std::string npy(const std::string& descr, const std::string& shape, const std::string& data,
                const std::string& fortran = "False") {
  std::string header = "{'descr': " + descr + ", 'fortran_order': " + fortran + ", 'shape': " + shape + ", }";
  header += std::string(117 - header.size() % 64 - 1, ' ') + "\n";
  return std::string("\x93NUMPY\x01\x00", 8) +
         bytes_of<std::uint16_t>({static_cast<std::uint16_t>(header.size())}) + header + data;
}

TEST_F(ForeignClouds, ArraysOfNumPyAreReadWhateverTheirShape) {
  const Points expected = {{1, 2, 3}, {5, 6, 7}};
  const std::vector<float> rows = {1, 2, 3, 4, 5, 6, 7, 8};
  EXPECT_EQ(read("a.npy", npy("'<f4'", "(2, 4)", bytes_of(rows))), expected);
  EXPECT_EQ(read("a.npy", npy("'>f4'", "(2, 4)", bytes_of(rows, std::endian::big))), expected);
  EXPECT_EQ(read("a.npy", npy("'<f4'", "(1, 2, 4)", bytes_of(rows))), expected);
  EXPECT_EQ(read("a.npy", npy("'<f8'", "(2, 3)", bytes_of<double>({1, 2, 3, 5, 6, 7}))), expected);
  EXPECT_EQ(read("a.npy", npy("'<f4'", "(2, 3)", bytes_of<float>({1, 5, 2, 6, 3, 7}), "True")), expected);
  EXPECT_EQ(
      read("a.npy", npy("[('i', '<u2'), ('x', '<f4'), ('y', '<f4'), ('z', '<f8')]", "(1,)",
                        bytes_of<std::uint16_t>({9}) + bytes_of<float>({1, 2}) + bytes_of<double>({3}))),
      (Points{{1, 2, 3}}));
}

TEST_F(ForeignClouds, WhatIsNoArrayOfPointsIsRefused) {
  const std::string data = bytes_of<float>({1, 2, 3, 4, 5, 6, 7, 8});
  for (const std::string shape : {"(8,)", "(4, 2)", "()", "(2, 4", "(-1, 4)", "(1, 1, 2, 4)", ""})
    file_error(path("a.npy"), "is no array of points", [&] { read("a.npy", npy("'<f4'", shape, data)); });
  file_error(path("a.npy"), "is no array of points", [&] { read("a.npy", npy("'<c8'", "(2, 4)", data)); });
  file_error(path("a.npy"), "ends inside point 2 of 3", [&] { read("a.npy", npy("'<f4'", "(3, 4)", data)); });
  file_error(path("a.npy"), "ends inside point",
             [&] { read("a.npy", npy("'<f4'", "(1000000000, 4)", data)); });
  file_error(path("a.npy"), "is no array of NumPy", [&] { read("a.npy", "nothing"); });
  const std::string whole = npy("'<f4'", "(2, 4)", data);
  for (std::size_t size = 1; size < whole.size(); ++size)
    file_error(path("a.npy"), "", [&] { read("a.npy", whole.substr(0, size)); });
}

TEST_F(ForeignClouds, TextsAreReadHoweverTheyAreDivided) {
  const Points expected = {{1, 2, 3}, {-4.5, 5e1, 0.25}};
  EXPECT_EQ(read("a.xyz", "1 2 3\n-4.5 5e1 .25\n"), expected);
  EXPECT_EQ(read("a.txt", "# by someone\n1\t2\t3 77\r\n\n-4.5  5e1 .25 78\r\n"), expected);
  EXPECT_EQ(read("a.csv", "1,2,3\n-4.5,5e1,.25"), expected);
  EXPECT_EQ(read("a.csv", "intensity;Z;X;Y\n9;3;1;2\n9;.25;-4.5;5e1\n"), expected);
  EXPECT_EQ(read("a.csv", "\"x\",\"y\",\"z\"\n1, 2, 3\n-4.5, 5e1, .25\n"), expected);
  EXPECT_EQ(read("a.xyz", "2\n1 2 3\n-4.5 5e1 .25\n"), expected);
  EXPECT_EQ(read("a.txt", "// x y z\n1 2 3\n-4.5 5e1 .25\n"), expected);
  const Scan scan = read_cloud(make("a.xyz", "nan 1 2\n0 0 0\n1 2 3\n"));
  EXPECT_EQ(scan.dropped_not_finite, 1U);
  EXPECT_EQ(scan.dropped_at_origin, 1U);
  EXPECT_EQ(scan.p_sensor, (Points{{1, 2, 3}}));
}

TEST_F(ForeignClouds, WrongLinesOfATextAreNamed) {
  expect_at_line(file_error(path("a.xyz"), "has 2 values", [&] { read("a.xyz", "1 2 3\n1 2\n"); }), 2);
  expect_at_line(file_error(path("a.xyz"), "holds 'two'", [&] { read("a.xyz", "1 2 3\n1 two 3\n"); }), 2);
  expect_at_line(file_error(path("a.txt"), "has 1 values", [&] { read("a.txt", "hello\n"); }), 1);
}

TEST_F(ForeignClouds, TextsBesideScansAreNone) {
  make("0.npy", npy("'<f4'", "(1, 3)", bytes_of<float>({1, 2, 3})));
  make("times.txt", "0.1\n");
  EXPECT_EQ(ScanFolder(folder_).size(), 1U);
  std::filesystem::remove(path("0.npy"));
  make("times.txt", "1 2 3\n");
  EXPECT_EQ(ScanFolder(folder_).size(), 1U);
}

}  // namespace
}  // namespace evermap
