// SPDX-FileCopyrightText: 2026 the evermap authors
// SPDX-License-Identifier: BSD-3-Clause
#include "files/file_fixture.hpp"
#include <evermap/io/kitti_bin.hpp>

namespace evermap {
namespace {

class KittiBinTest : public FileTest {};

TEST_F(KittiBinTest, PointsAreReadInOrder) {
  const Scan scan = read_kitti_bin(make("a.bin", bytes_of<float>({1, 2, 3, 0.5F, -4.25F, 5, 6, 0})));
  ASSERT_EQ(scan.p_sensor.size(), 2U);
  EXPECT_EQ(scan.p_sensor[0], Eigen::Vector3d(1, 2, 3));
  EXPECT_EQ(scan.p_sensor[1], Eigen::Vector3d(-4.25, 5, 6));
  EXPECT_TRUE(scan.time_offset.empty());
  EXPECT_FALSE(scan.T_map_sensor);
}

TEST_F(KittiBinTest, PointsWithoutAPlaceAreDroppedAndCounted) {
  const Scan scan = read_kitti_bin(make("a.bin", bytes_of<float>({kNaN, 2,     3,     0,  //
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

TEST_F(KittiBinTest, IncompletePointIsNamedByItsOffset) {
  const std::string three = bytes_of<float>({1, 2, 3, 0, 1, 2, 3, 0, 1, 2, 3, 0});
  for (std::size_t size = 1; size <= three.size(); ++size) {
    const std::filesystem::path file = make("a.bin", three.substr(0, size));
    if (size % 16 == 0) {
      EXPECT_EQ(read_kitti_bin(file).p_sensor.size(), size / 16);
    } else {
      expect_at_byte(file_error(file, "the last point has", [&] { read_kitti_bin(file); }), size / 16 * 16);
    }
  }
}

TEST_F(KittiBinTest, WhatIsNoFileWithPointsIsRefused) {
  file_error(path("no.bin"), "No such file", [&] { read_kitti_bin(path("no.bin")); });
  file_error(folder_, "is a folder", [&] { read_kitti_bin(folder_); });
  file_error(make("e.bin", ""), "is empty", [&] { read_kitti_bin(path("e.bin")); });
  file_error("/dev/zero", "no regular file", [] { read_kitti_bin("/dev/zero"); });
}

TEST_F(KittiBinTest, UnreadableFileIsNamed) {
  std::filesystem::permissions(folder_, std::filesystem::perms(0755));
  std::filesystem::permissions(make("a.bin", "x"), std::filesystem::perms::none);
  const Unprivileged unprivileged;
  file_error(path("a.bin"), "Permission denied", [&] { read_kitti_bin(path("a.bin")); });
}

}  // namespace
}  // namespace evermap
