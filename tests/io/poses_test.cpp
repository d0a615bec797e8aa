// SPDX-FileCopyrightText: 2026 the evermap authors
// SPDX-License-Identifier: BSD-3-Clause
#include <clocale>
#include <cmath>
#include <cstdint>
#include <locale>
#include <sstream>

#include "files/file_fixture.hpp"
#include <evermap/io/poses.hpp>

namespace evermap {
namespace {

class PosesTest : public FileTest {
 protected:
  std::vector<StampedPose> read(std::string_view text) { return read_poses(make("poses.txt", text)).poses; }
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

TEST_F(PosesTest, TimesAreInSecondsWhateverTheirUnit) {
  for (const double begin : {0.0, 5000.0, 1691000000.0}) {  // since the start, a day's, since 1970
    for (const double step : {0.02, 0.1, 2.0}) {            // [s]
      for (const std::int64_t ticks : {1, 1000, 1000000, 1000000000}) {  // a second
        if (ticks == 1 && step < 1) continue;
        std::ostringstream text;
        for (int i = 0; i < 9; ++i) {
          const double time = begin + step * (i + (i > 4 ? 700 : 0));  // with a gap
          text << std::llround(time * static_cast<double>(ticks)) << " 0 0 0 0 0 0 1\n";
        }
        const PoseFile file = read_poses(make("poses.txt", text.str()));
        EXPECT_EQ(file.seconds_per_tick, 1 / static_cast<double>(ticks)) << text.str();
        EXPECT_NEAR(*file.poses[4].time, begin + 4 * step, 1e-3) << text.str();
      }
    }
  }
  const PoseFile fractions = read_poses(make("poses.txt", "0.1 0 0 0 0 0 0 1\n0.2 0 0 0 0 0 0 1\n"));
  EXPECT_EQ(fractions.seconds_per_tick, 1);
}

TEST_F(PosesTest, KittiIsRowMajor) {
  const auto poses = read("0 -1 0 10 1 0 0 20 0 0 1 30");
  ASSERT_EQ(poses.size(), 1U);
  EXPECT_FALSE(poses[0].time);
  EXPECT_LT((poses[0].T_map_sensor * Eigen::Vector3d(1, 0, 0) - Eigen::Vector3d(10, 21, 30)).norm(), 1e-12);
}

TEST_F(PosesTest, KittiIsWrittenAsItIsRead) {
  const std::vector<StampedPose> poses = read("1 0.1 -0.2 3 0 0 0.6 0.8\n2 1e6 0 -4 0 0.28 0 0.96\n");
  write_kitti_poses(path("poses.kitti"), poses);
  const std::vector<StampedPose> again = read_poses(path("poses.kitti")).poses;
  ASSERT_EQ(again.size(), 2U);
  for (std::size_t i = 0; i < 2; ++i) {
    EXPECT_FALSE(again[i].time);
    EXPECT_LT((again[i].T_map_sensor.rotation - poses[i].T_map_sensor.rotation).norm(), 1e-11);
    EXPECT_LT((again[i].T_map_sensor.translation - poses[i].T_map_sensor.translation).norm(), 1e-5);
  }
}

TEST_F(PosesTest, CalibrationTurnsPosesOfACameraIntoThoseOfTheLidar) {
  // The camera sits 0.3 m ahead of the LiDAR and 0.1 m below it, and looks along its x axis.
  const SensorMount mount = read_kitti_calibration(
      make("calib.txt", "P0: 7 0 6 0 0 7 2 0 0 0 1 0\nTr: 0 -1 0 0 0 0 -1 -0.1 1 0 0 -0.3\n"));
  const Pose T_lidar_camera = mount.T_base_sensor.inverse();
  EXPECT_LT((T_lidar_camera.translation - Eigen::Vector3d(0.3, 0, -0.1)).norm(), 1e-12);
  EXPECT_EQ(mount.sensor_of(Pose{}).translation.norm(), 0);
  const Pose ahead{Eigen::Matrix3d::Identity(), {0, 0, 5}};  // along the camera's z axis
  EXPECT_LT((mount.sensor_of(ahead).translation - Eigen::Vector3d(5, 0, 0)).norm(), 1e-12);

  const SensorMount raw = read_kitti_calibration(
      make("calib_velo_to_cam.txt", "calib_time: 15-Mar-2012\nR: 0 -1 0 0 0 -1 1 0 0\nT: 0 -0.1 -0.3\n"));
  EXPECT_EQ(raw.T_base_sensor.translation, mount.T_base_sensor.translation);
  EXPECT_EQ(raw.T_base_sensor.rotation, mount.T_base_sensor.rotation);
}

TEST_F(PosesTest, WhatIsNoCalibrationIsNamed) {
  for (const auto& [text, message] :
       std::vector<std::pair<std::string, std::string>>{{"1 0 0 0 0 1 0 0 0 0 1 0\n", "no line \"Tr:\""},
                                                        {"Tr: 1 2 3\n", "no line \"Tr:\""},
                                                        {"Tr: 1 0 0 0 0 1 0 0 0 0 x 0\n", "no number"},
                                                        {"R: 1 0 0 0 1 0 0 0 nan\nT: 0 0 0\n", "no number"},
                                                        {"Tr: 1 0 0 0 0 2 0 0 0 0 1 0\n", "no rotation"}}) {
    const std::filesystem::path file = make("calib.txt", text);
    file_error(file, message, [&] { read_kitti_calibration(file); });
  }
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
  expect_at_line(error(good + "1e300 0 0 0 0 0 0 1\n", "that no drive reaches"), 3);
  expect_at_line(error(good + "2 0 -1e300 0 0 0 0 1\n", "that no drive reaches"), 3);
  expect_at_line(error("1 0 0 1e9 0 1 0 0 0 0 1 0\n", "that no drive reaches"), 1);
  expect_at_line(error(good + "2 0 0 0 0 0 0 0\n", "has norm 0.0"), 3);
  expect_at_line(error(good + "2 0 0 0 0 0 0 1.02\n", "has norm 1.02"), 3);
  expect_at_line(error(good + "\n1 0 0 0 0 0 0 1\n", "not later"), 4);
  expect_at_line(error(good + "0.5 0 0 0 0 0 0 1\n", "not later"), 3);
  expect_at_line(error("1 2 3\n", "has 3 numbers"), 1);
  expect_at_line(error("1 0 0 0 0 1 0 0 0 0 -1 0\n", "is no rotation"), 1);
  expect_at_line(error("1 0 0 0 0 1 0 0 0 0 1.01 0\n", "is no rotation"), 1);
  expect_at_line(error("0 0 0 0 0 0 0 0 0 0 0 0\n", "is no rotation"), 1);
}

/// Whatever a pose holds, its line holds nothing else: no byte behind the number's end.
TEST_F(PosesTest, LongNumbersAreWrittenWhole) {
  const double longest = -std::numeric_limits<double>::max();
  StampedPose pose{longest, {}};
  pose.T_map_sensor.translation = {longest, -1.23456789e-300, longest};
  write_tum_poses(path("a.txt"), {pose, pose});
  const std::string text = content(path("a.txt"));
  EXPECT_EQ(text.find_first_not_of("0123456789+-.e \n"), std::string::npos);
  EXPECT_EQ(std::count(text.begin(), text.end(), '\n'), 2);
  const std::string line = text.substr(0, text.find('\n') + 1);
  EXPECT_EQ(text, line + line);
  EXPECT_TRUE(line.starts_with(std::to_string(longest) + " -1.79769313e+308 -1.23456789e-300 ")) << line;
  EXPECT_TRUE(line.ends_with(" 0 0 0 1\n")) << line;
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
