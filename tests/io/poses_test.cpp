// SPDX-FileCopyrightText: 2026 the evermap authors
// SPDX-License-Identifier: BSD-3-Clause
#include <clocale>
#include <locale>

#include "files/file_fixture.hpp"
#include <evermap/io/poses.hpp>

namespace evermap {
namespace {

class PosesTest : public FileTest {
 protected:
  std::vector<StampedPose> read(std::string_view text) { return read_poses(make("poses.txt", text)); }
  FileError error(std::string_view text, std::string_view message) {
    const std::filesystem::path file = make("poses.txt", text);
    return file_error(file, message, [&] { read_poses(file); });
  }
};

TEST_F(PosesTest, Tum) {
  const auto poses = read(
      "# timestamp x y z qx qy qz qw\n"
      "1691000000.25 1 2 3 0 0 0 1\n"
      "\n"
      "  1691000001.5\t-1e3 +2.5 .5 0 0 0.70710678 0.70710678\r\n");
  ASSERT_EQ(poses.size(), 2U);
  EXPECT_EQ(poses[0].time, 1691000000.25);
  EXPECT_EQ(poses[0].T_map_sensor.translation, Eigen::Vector3d(1, 2, 3));
  EXPECT_EQ(poses[0].T_map_sensor.rotation, Eigen::Matrix3d::Identity());
  EXPECT_EQ(poses[1].T_map_sensor.translation, Eigen::Vector3d(-1000, 2.5, 0.5));
  const Eigen::Vector3d turned = poses[1].T_map_sensor.rotation * Eigen::Vector3d::UnitX();
  EXPECT_LT((turned - Eigen::Vector3d::UnitY()).norm(), 1e-12) << "a quarter turn about z, normalized";
}

TEST_F(PosesTest, KittiIsRowMajor) {
  const auto poses = read("0 -1 0 10 1 0 0 20 0 0 1 30");
  ASSERT_EQ(poses.size(), 1U);
  EXPECT_FALSE(poses[0].time);
  EXPECT_LT((poses[0].T_map_sensor * Eigen::Vector3d(1, 0, 0) - Eigen::Vector3d(10, 21, 30)).norm(), 1e-12);
}

TEST_F(PosesTest, RoundedMatricesBecomeRotations) {
  const auto poses = read("0.9998 -0.0175 0 0 0.0175 0.9998 0 0 0 0 1 0");
  EXPECT_TRUE(is_rotation(poses.at(0).T_map_sensor.rotation, 1e-12));
}

TEST_F(PosesTest, TheProgramsLocaleDoesNotMatter) {
  struct DecimalComma : std::numpunct<char> {
    char do_decimal_point() const override { return ','; }
  };
  const std::locale before = std::locale::global(std::locale(std::locale(), new DecimalComma));
  const std::string c_before = std::setlocale(LC_ALL, nullptr);
  std::setlocale(LC_ALL, "de_DE.UTF-8");  // where installed, for functions of C
  const auto poses = read("1.5 2.5 0 0 0 0 0 1");
  std::setlocale(LC_ALL, c_before.c_str());
  std::locale::global(before);
  EXPECT_EQ(poses.at(0).T_map_sensor.translation.x(), 2.5);
}

TEST_F(PosesTest, BadLinesAreNamed) {
  const std::string good = "# comment\n1 0 0 0 0 0 0 1\n";
  expect_at_line(error(good + "2 0 0 0 0 0 1\n", "has 7 numbers"), 3);
  expect_at_line(error(good + "1 0 0 0 0 1 0 0 0 0 1 0\n", "has 12 numbers"), 3);
  expect_at_line(error(good + "2 0 0 0 0 0 0 1 9\n", "has 9 numbers"), 3);
  expect_at_line(error(good + "2 0 zero 0 0 0 0 1\n", "'zero' is no number"), 3);
  expect_at_line(error(good + "2 0 1,5 0 0 0 0 1\n", "'1,5' is no number"), 3);
  expect_at_line(error(good + "2 0 1e999 0 0 0 0 1\n", "'1e999' is no number"), 3);
  expect_at_line(error(good + "2 0 nan 0 0 0 0 1\n", "not finite"), 3);
  expect_at_line(error(good + "inf 0 0 0 0 0 0 1\n", "not finite"), 3);
  expect_at_line(error(good + "2 0 0 0 0 0 0 0\n", "has norm 0.0"), 3);
  expect_at_line(error(good + "2 0 0 0 0 0 0 1.02\n", "has norm 1.02"), 3);
  expect_at_line(error(good + "\n1 0 0 0 0 0 0 1\n", "not later"), 4);
  expect_at_line(error(good + "0.5 0 0 0 0 0 0 1\n", "not later"), 3);
  expect_at_line(error("1 2 3\n", "has 3 numbers"), 1);
  expect_at_line(error("1 0 0 0 0 1 0 0 0 0 -1 0\n", "is no rotation"), 1);
  expect_at_line(error("1 0 0 0 0 1 0 0 0 0 1.01 0\n", "is no rotation"), 1);
  expect_at_line(error("0 0 0 0 0 0 0 0 0 0 0 0\n", "is no rotation"), 1);
}

TEST_F(PosesTest, FilesWithoutPosesAreRefused) {
  error("", "is empty");
  error("# nothing\n\n", "holds no pose");
  file_error(path("none"), "No such file", [&] { read_poses(path("none")); });
  file_error(folder_, "is a folder", [&] { read_poses(folder_); });
}

TEST_F(PosesTest, GarbageIsQuotedOnOneLine) {
  error(std::string("\0\x01\xff\x7f garbage\n", 13), "is no number");
  error(std::string(1 << 20, 'x'), "xxx...' is no number");
}

}  // namespace
}  // namespace evermap
