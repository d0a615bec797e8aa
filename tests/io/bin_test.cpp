// SPDX-FileCopyrightText: 2026 the evermap authors
// SPDX-License-Identifier: BSD-3-Clause
#include <random>

#include <Eigen/Core>

#include "files/file_fixture.hpp"
#include <evermap/io/detail/bin.hpp>

namespace evermap {
namespace {

class BinTest : public FileTest {};

TEST_F(BinTest, PointsAreReadInOrder) {
  const Scan scan = read_bin(make("a.bin", bytes_of<float>({1, 2, 3, 0.5F, -4.25F, 5, 6, 0})));
  ASSERT_EQ(scan.p_sensor.size(), 2U);
  EXPECT_EQ(scan.p_sensor[0], Eigen::Vector3d(1, 2, 3));
  EXPECT_EQ(scan.p_sensor[1], Eigen::Vector3d(-4.25, 5, 6));
  EXPECT_TRUE(scan.time_offset.empty());
  EXPECT_FALSE(scan.T_map_sensor);
}

TEST_F(BinTest, PointsWithoutAPlaceAreDroppedAndCounted) {
  const Scan scan = read_bin(make("a.bin", bytes_of<float>({kNaN, 2,     3,     0,  //
                                                            1,    kInf,  3,     0,  //
                                                            1,    2,     -kInf, 0,  //
                                                            0,    0,     0,     9,  //
                                                            0,    -0.0F, 0,     9,  //
                                                            1,    2,     3,     kNaN})));
  ASSERT_EQ(scan.p_sensor.size(), 1U);
  EXPECT_EQ(scan.p_sensor[0], Eigen::Vector3d(1, 2, 3));
  EXPECT_EQ(scan.dropped_not_finite, 3U);
  EXPECT_EQ(scan.dropped_at_origin, 2U);
}

TEST_F(BinTest, IncompletePointIsNamedByItsOffset) {
  const std::string three = bytes_of<float>({1, 2, 3, 0, 1, 2, 3, 0, 1, 2, 3, 0});
  for (std::size_t size = 1; size <= three.size(); ++size) {
    const std::filesystem::path file = make("a.bin", three.substr(0, size));
    if (size % 16 == 0) {
      EXPECT_EQ(read_bin(file).p_sensor.size(), size / 16);
    } else {
      expect_at_byte(file_error(file, "the last point has", [&] { read_bin(file); }), size / 16 * 16);
    }
  }
}

TEST_F(BinTest, WhatIsNoFileWithPointsIsRefused) {
  file_error(path("no.bin"), "No such file", [&] { read_bin(path("no.bin")); });
  file_error(folder_, "is a folder", [&] { read_bin(folder_); });
  file_error(make("e.bin", ""), "is empty", [&] { read_bin(path("e.bin")); });
  file_error("/dev/zero", "no regular file", [] { read_bin("/dev/zero"); });
}

TEST_F(BinTest, UnreadableFileIsNamed) {
  std::filesystem::permissions(folder_, std::filesystem::perms(0755));
  std::filesystem::permissions(make("a.bin", "x"), std::filesystem::perms::none);
  const Unprivileged unprivileged;
  file_error(path("a.bin"), "Permission denied", [&] { read_bin(path("a.bin")); });
}

/// A scan as a spinning sensor records it, `fields` values a point: place, intensity, ring, time.
std::vector<float> lidar_values(std::size_t points, std::size_t fields, unsigned seed = 1) {
  std::mt19937 random(seed);
  std::uniform_real_distribution<float> uniform(0, 1);
  std::vector<float> values;
  for (std::size_t i = 0; i < points; ++i) {
    const auto ring = static_cast<float>(i % 32);
    const float azimuth = 6.28F * static_cast<float>(i) / static_cast<float>(points);
    const float range = 5 + 40 * uniform(random);
    const std::array<float, 6> all = {range * std::cos(azimuth),
                                      range * std::sin(azimuth),
                                      -1.7F + 0.1F * ring,
                                      uniform(random),
                                      ring,
                                      0.1F * static_cast<float>(i) / static_cast<float>(points)};
    values.insert(values.end(), all.begin(), all.begin() + static_cast<std::ptrdiff_t>(fields));
  }
  return values;
}

TEST_F(BinTest, TheDataTellsHowManyValuesAPointHas) {
  for (const std::size_t fields : {3U, 4U, 5U, 6U}) {
    // Numbers of points that any of the layouts divides.
    for (const std::size_t points : {180U, 6000U}) {
      const std::vector<float> values = lidar_values(points, fields);
      CloudNotes notes;
      const Scan scan = read_bin(make("a.bin", bytes_of(values)), std::nullopt, &notes);
      EXPECT_EQ(notes.bin_fields, fields) << points;
      ASSERT_EQ(scan.p_sensor.size(), points);
      EXPECT_EQ(scan.p_sensor[17].cast<float>(), Eigen::Vector3f(values.data() + 17 * fields));
    }
  }
}

TEST_F(BinTest, StrayValuesDoNotChangeTheLayout) {
  std::vector<float> values = lidar_values(6000, 4);
  values[4 * 100] = 1e9F;
  values[4 * 200 + 2] = -kInf;
  for (std::size_t i = 0; i < 600; ++i)
    std::fill_n(values.begin() + static_cast<std::ptrdiff_t>(40 * i), 3, kNaN);
  CloudNotes notes;
  read_bin(make("a.bin", bytes_of(values)), std::nullopt, &notes);
  EXPECT_EQ(notes.bin_fields, 4U);
}

TEST_F(BinTest, ACutFileIsNotTakenForAnotherLayout) {
  std::vector<float> values = lidar_values(6000, 4);
  values.resize(values.size() - 3);  // a whole number of points of 3
  const std::filesystem::path file = make("a.bin", bytes_of(values));
  expect_at_byte(file_error(file, "the last point has 4 of 16 bytes", [&] { read_bin(file); }),
                 16 * (values.size() / 4));
}

TEST_F(BinTest, WhatCannotBeToldIsAskedFor) {
  std::mt19937 random(5);
  std::uniform_real_distribution<float> uniform(-10, 10);
  std::vector<float> noise(6000);
  for (float& value : noise) value = uniform(random);
  const std::filesystem::path file = make("a.bin", bytes_of(noise));
  file_error(file, "say it with --bin-fields", [&] { read_bin(file); });
  EXPECT_EQ(read_bin(file, 5).p_sensor.size(), 1200U);
  EXPECT_EQ(read_bin(file, 4).p_sensor.size(), 1500U);
  file_error(file, "a point has 3 to 64 values, not 2", [&] { read_bin(file, 2); });
  file_error(file, "a point has 3 to 64 values, not 65", [&] { read_bin(file, 65); });
}

TEST_F(BinTest, AFileOfOneValueIsReadAsUsual) {
  EXPECT_EQ(read_bin(make("a.bin", std::string(4800, '\0'))).dropped_at_origin, 300U);
}

}  // namespace
}  // namespace evermap
