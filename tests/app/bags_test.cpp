// SPDX-FileCopyrightText: 2026 the evermap authors
// SPDX-License-Identifier: BSD-3-Clause
#include <Eigen/Geometry>

#include "app/program.hpp"
#include "bags/bag_writer.hpp"
#include <evermap/io/cloud.hpp>
#include <evermap/io/poses.hpp>

namespace evermap {
namespace {

/// A drive through the room of ProgramTest as a folder of scans, and the same in bags.
class BagsTest : public ProgramTest {
 protected:
  static constexpr double kStart = 1700000000;  // [s]
  static constexpr int kScans = 6;

  BagsTest() {
    make_hall_drive("drive", kScans);
    std::vector<StampedPose> poses = read_poses(path("drive.txt")).poses;
    for (std::size_t i = 0; i < poses.size(); ++i) poses[i].time = kStart + 0.1 * static_cast<double>(i);
    write_tum_poses(path("stamped.txt"), poses);
    for (std::size_t i = 0; i < poses.size(); ++i) {
      points_.emplace_back();
      for (const Eigen::Vector3d& p : scan(i).p_sensor) {
        const Eigen::Vector3f q = p.cast<float>();
        points_.back().push_back({q.x(), q.y(), q.z(), 0});
      }
    }
    poses_ = read_poses(path("stamped.txt")).poses;
  }

  Scan scan(std::size_t index) const {
    return read_cloud(path("drive") / (std::to_string(10000 + index) + ".bin"));
  }

  std::vector<WrittenMessage> messages(Wire wire) const {
    std::vector<WrittenMessage> messages;
    messages.push_back({"/tf_static", "tf2_msgs/TFMessage", kStart - 1,
                        transform_message(wire, kStart - 1, "base_link", "lidar", Pose{})});
    for (std::size_t i = 0; i < poses_.size(); ++i) {
      const double time = *poses_[i].time;
      messages.push_back(
          {"/points", "sensor_msgs/PointCloud2", time, cloud_message(wire, time, "lidar", points_[i])});
      for (const std::string parent : {"map", "odom"}) {
        const bool is_map = parent == "map";
        messages.push_back(
            {"/tf", "tf2_msgs/TFMessage", time,
             transform_message(wire, time, parent, is_map ? "odom" : "base_link",
                               is_map ? poses_.front().T_map_sensor
                                      : poses_.front().T_map_sensor.inverse() * poses_[i].T_map_sensor)});
      }
    }
    return messages;
  }

  std::string map_of(const std::string& scans, const std::string& poses) const {
    std::filesystem::remove(path("out.evm"));
    const Result result = run({"build", name(scans), "--poses", poses, "-r", "0.4", "-o", name("out.evm")});
    EXPECT_EQ(result.exit_code, 0) << result.err;
    return content(path("out.evm"));
  }

  std::vector<std::vector<CloudPoint>> points_;
  std::vector<StampedPose> poses_;
};

TEST_F(BagsTest, ABagGivesTheSameMapAsAFolder) {
  make("drive.bag", ros1_bag(messages(Wire::kRos1), {"lz4", true, 3}));
  make("drive.mcap", mcap_bag(messages(Wire::kCdr), Wire::kCdr, {"zstd", false, 3}));
  write_sqlite_bag(path("drive.db3"), messages(Wire::kCdr));
  const std::string expected = map_of("drive", name("stamped.txt"));
  EXPECT_GT(expected.size(), 1000U);
  for (const std::string bag : {"drive.bag", "drive.mcap", "drive.db3"})
    EXPECT_EQ(map_of(bag, name("stamped.txt")), expected) << bag;
  const std::string by_frame = map_of("drive.bag", "map");
  EXPECT_EQ(by_frame.size(), expected.size());
  EXPECT_EQ(map_of("drive.mcap", "map"), by_frame);
}

TEST_F(BagsTest, WhatABagHoldsIsShownWithTheCommandThatUsesIt) {
  make("drive.bag", ros1_bag(messages(Wire::kRos1)));
  const Result result = run({"info", name("drive.bag")});
  EXPECT_EQ(result.exit_code, 0) << result.err;
  for (const std::string text :
       {"/points  sensor_msgs/PointCloud2  6 messages, 10.00 Hz", "frame lidar, 1 x 11488 points: x float32",
        "frames   base_link lidar map odom", "drive.bag --odometry odom -r 0.2 -o map.evm", "--poses map"}) {
    EXPECT_NE(result.out.find(text), std::string::npos) << result.out << "lacks: " << text;
  }
  const Result json = run({"info", "--json", name("drive.bag")});
  EXPECT_EQ(json.exit_code, 0);
  EXPECT_NE(json.out.find("\"poses_from\""), std::string::npos) << json.out;
}

TEST_F(BagsTest, OdometryOfABagIsUsedUnlessItIsDeclined) {
  make("drive.bag", ros1_bag(messages(Wire::kRos1)));
  map_of("drive", name("stamped.txt"));
  const std::vector<std::string> localize = {"localize", name("out.evm"), name("drive.bag"), "-o",
                                             name("poses.txt")};
  const Result used = run(localize);
  EXPECT_EQ(used.exit_code, 0) << used.err;
  EXPECT_NE(used.out.find("odometry for 6 scans"), std::string::npos) << used.out;
  std::vector<std::string> declined = localize;
  declined.insert(declined.end(), {"--odometry", "none"});
  const Result unused = run(declined);
  EXPECT_NE(unused.out.find("states"), std::string::npos) << unused.out;
  EXPECT_EQ(unused.out.find("odometry for"), std::string::npos) << unused.out;
  ASSERT_EQ(run(localize).exit_code, 0);
  const std::vector<StampedPose> found = read_poses(path("poses.txt")).poses;
  EXPECT_NEAR(found.front().time.value_or(0), kStart, 1e-5);
}

TEST_F(BagsTest, PosesAreWrittenAsABagOfTheBaseThatCanBeUsedAsPoses) {
  std::vector<WrittenMessage> recorded = messages(Wire::kCdr);
  const Pose T_base_sensor{Eigen::AngleAxisd(0.5, Eigen::Vector3d::UnitZ()).toRotationMatrix(),
                           {0.4, 0, 1.2}};
  recorded.insert(recorded.begin(),
                  {"/tf_static", "tf2_msgs/TFMessage", kStart - 1,
                   transform_message(Wire::kCdr, kStart - 1, "lidar", "vehicle", T_base_sensor.inverse())});
  make("drive.mcap", mcap_bag(recorded, Wire::kCdr));
  expect_done({"build", name("drive"), "--poses", name("stamped.txt"), "-r", "0.4", "-o", name("map.evm"),
               "--map-frame", "world"});
  const auto localized = [&](const std::string& poses, std::vector<std::string> more) {
    std::vector<std::string> arguments = {"localize", name("map.evm"), name("drive.mcap"), "-o", name(poses)};
    arguments.insert(arguments.end(), more.begin(), more.end());
    return arguments;
  };
  expect_done(localized("sensor.txt", {}));
  expect_done(localized("vehicle.mcap", {"--base-frame", "vehicle"}));
  expect_done(localized("vehicle.kitti", {"--base-frame", "vehicle"}));
  const std::vector<StampedPose> of_sensor = read_poses(path("sensor.txt")).poses;
  const std::vector<StampedPose> of_vehicle = read_poses(path("vehicle.kitti")).poses;
  ASSERT_EQ(of_sensor.size(), static_cast<std::size_t>(kScans));
  ASSERT_EQ(of_vehicle.size(), of_sensor.size());
  for (std::size_t i = 0; i < of_sensor.size(); ++i) {
    const Pose expected = of_sensor[i].T_map_sensor * T_base_sensor.inverse();
    EXPECT_LT((of_vehicle[i].T_map_sensor.translation - expected.translation).norm(), 1e-6);
  }
  const Result summary = run({"info", name("vehicle.mcap")});
  for (const std::string text :
       {"/evermap/odometry  nav_msgs/Odometry  6 messages", "frames   vehicle world"})
    EXPECT_NE(summary.out.find(text), std::string::npos) << summary.out << "lacks: " << text;
  expect_failed(localized("none.txt", {"--base-frame", "boat"}), "nothing tells where boat is on the sensor");
}

TEST_F(BagsTest, PosesOfAVehicleBecomeThoseOfTheSensorByTheExtrinsic) {
  make("drive.bag", ros1_bag(messages(Wire::kRos1)));
  const std::string expected = map_of("drive", name("stamped.txt"));
  const Pose T_vehicle_sensor{Eigen::Matrix3d::Identity(), {0.5, 0.25, 1}};
  std::vector<StampedPose> of_vehicle = poses_;
  for (StampedPose& pose : of_vehicle) pose.T_map_sensor = pose.T_map_sensor * T_vehicle_sensor.inverse();
  write_tum_poses(path("vehicle.txt"), of_vehicle);
  const std::vector<std::string> build = {
      "build", name("drive"), "--poses",           name("vehicle.txt"), "-r",
      "0.4",   "-o",          name("mounted.evm"), "--extrinsic",       "0.5 0.25 1 0 0 0 1"};
  expect_done(build);
  EXPECT_EQ(content(path("mounted.evm")).size(), expected.size());
  std::filesystem::remove(path("out.evm"));
  expect_failed({"build", name("drive.bag"), "--poses", "map", "-r", "0.4", "-o", name("out.evm"),
                 "--extrinsic", "0 0 1 0 0 0 1"},
                "its /tf tells where the sensor is");
  expect_failed(
      {"localize", name("mounted.evm"), name("drive"), "-o", name("p.txt"), "--extrinsic", "0 0 1 0 0 0 1"},
      "tells nothing without --odometry");
}

TEST_F(BagsTest, WhatCannotBeUsedIsNamed) {
  make("drive.bag", ros1_bag(messages(Wire::kRos1)));
  expect_failed({"build", name("drive.bag"), "--poses", "earth", "-r", "0.4", "-o", name("out.evm")},
                "none of its 6 scans has a pose by earth");
  make("late.txt", "5 0 0 0 0 0 0 1\n6 0 0 0 0 0 0 1\n");
  expect_failed({"build", name("drive.bag"), "--poses", name("late.txt"), "-r", "0.4", "-o", name("out.evm")},
                "give poses of this recording, in its clock");
  expect_failed({"build", name("drive.bag"), "--topic", "/scan", "-r", "0.4", "-o", name("out.evm")},
                "has no clouds on /scan; it has /points");
}

TEST_F(BagsTest, ABagThatWasCutOffIsReadAsFarAsItGoesAndItIsSaid) {
  const std::string whole = ros1_bag(messages(Wire::kRos1), {"none", false, 3});
  make("cut.bag", whole.substr(0, whole.size() * 2 / 3));
  const Result result = run({"build", name("cut.bag"), "--poses", "map", "-r", "0.4", "-o", name("out.evm")});
  EXPECT_EQ(result.exit_code, 0);
  EXPECT_NE(result.err.find("ends inside a record"), std::string::npos) << result.err;
  EXPECT_NE(result.err.find("was read"), std::string::npos) << result.err;
}

}  // namespace
}  // namespace evermap
