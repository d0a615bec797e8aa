// SPDX-FileCopyrightText: 2026 the evermap authors
// SPDX-License-Identifier: BSD-3-Clause
#include <ros_messages.h>
#include <unistd.h>

#include <gtest/gtest.h>

#include "files/file_fixture.hpp"
#include <evermap/history/map_store.hpp>
#include <evermap/io/map_file.hpp>
#include <evermap/io/poses.hpp>
#include <evermap/maintenance/survey.hpp>
#include <evermap/ros/detail/dds.hpp>
#include <evermap/ros/detail/idl_types.hpp>
#include <evermap/ros/map_server.hpp>
#include <evermap/ros/scan_publisher.hpp>
#include <evermap/simulation/scenario_drive.hpp>

namespace evermap {
namespace {

constexpr double kEdge = 0.4;  // [m]

/// Tests run at the same time: each process in a domain of its own.
unsigned domain() { return 1 + static_cast<unsigned>(::getpid()) % 100; }

const ScenarioDrive& drive() {
  static const ScenarioDrive kDrive = [] {
    Scenario scenario = shipped_scenario("yard");
    scenario.lidar.columns = 512;
    return ScenarioDrive(scenario);
  }();
  return kDrive;
}

const Pose kBaseOnSensor = {Eigen::Matrix3d::Identity(), {-0.5, 0, -1}};  // T_sensor_base

/// A robot in the yard and the map keeper, in one process and without threads.
class MapServerTest : public FileTest {
 protected:
  static constexpr const char* kFrame = "lidar";

  /// What the robot hears.
  struct Ears {
    explicit Ears(DdsNode& node)
        : transforms(node, "/tf", tf2_msgs_msg_dds__TFMessage__desc, Delivery::kReliable, 100),
          replies(node, "/evermap/reply", std_msgs_msg_dds__String__desc, Delivery::kReliable, 10),
          maps(node, "/evermap/map", sensor_msgs_msg_dds__PointCloud2__desc, Delivery::kLatched, 1),
          diagnostics(node, "/diagnostics", diagnostic_msgs_msg_dds__DiagnosticArray__desc,
                      Delivery::kReliable, 10),
          commands(node, "/evermap/command", std_msgs_msg_dds__String__desc, Delivery::kReliable) {}
    DdsReader transforms;
    DdsReader replies;
    DdsReader maps;
    DdsReader diagnostics;
    DdsWriter commands;
  };

  MapServerTest() {
    Scan survey;
    survey.p_sensor = drive().survey(kEdge / 4);
    Octree map(VoxelGrid{kEdge});
    add_survey(map, survey, {});
    save_map(path("map.evm"), map);
    store_.emplace(path("map.evm"));
    options_.domain = domain();
    options_.is_local = true;
    options_.T_map_base_initial = drive().T_map_sensor(0) * kBaseOnSensor;
    options_.last_pose = path("map.evm.pose");
  }

  MapServer& server() {
    if (!server_) {
      server_.emplace(*store_, store_->load(), Parameters{}, MapCause{"serve", ""}, options_);
      while (robot_.listeners() == 0) server_->step(0.01);
      robot_.send_transforms({{0, options_.base_frame, kFrame, kBaseOnSensor.inverse()}}, true);
    }
    return *server_;
  }

  /// Sends a scan, and odometry if there is any; what the server made of it, or nothing after a second.
  std::optional<ScanResult> drive_scan(std::size_t i, const std::optional<Pose>& T_odom_map = {},
                                       double late = 0) {
    server();
    Scan scan = drive().scan(i % drive().size()).scan;
    scan.time = 100 + drive().time(i) + late;
    if (T_odom_map) {
      const Pose T_odom_base = *T_odom_map * drive().T_map_sensor(i) * kBaseOnSensor;
      for (const double after : {-0.05, 0.0, 0.01})
        robot_.send_transforms({{*scan.time + after, "odom", options_.base_frame, T_odom_base}}, false);
    }
    robot_.send_cloud(scan, kFrame);
    return next_result();
  }
  /// None when the cloud was left out, or nothing came of it for three seconds.
  std::optional<ScanResult> next_result() {
    const auto left_out = [&] { return server().counts().not_later + server().counts().without_odometry; };
    const std::size_t before = left_out();
    for (int i = 0; i < 300 && left_out() == before; ++i) {
      if (std::optional<ScanResult> result = server().step(0.01)) return result;
    }
    return std::nullopt;
  }

  std::vector<StampedTransform> transforms_heard() {
    server().step(0.05);
    std::vector<StampedTransform> heard;
    for (const DdsMessage& message : ears_.transforms.take()) {
      for (const StampedTransform& one : read_transforms(ears_.transforms.topic(), message.bytes))
        if (one.parent == "map") heard.push_back(one);
    }
    return heard;
  }
  std::string command(const std::string& text) {
    std_msgs_msg_dds__String_ message{const_cast<char*>(text.c_str())};
    server();
    while (ears_.commands.readers() == 0) server().step(0.01);
    ears_.commands.write(&message);
    for (int i = 0; i < 500; ++i) {
      server().step(0.01);
      for (const DdsMessage& reply : ears_.replies.take())
        return std::string(WireReader(reply.bytes, Wire::kCdr).text());
    }
    return "no reply";
  }
  static double error(const Pose& found, const Pose& truth) {
    return (found.translation - truth.translation).norm();
  }

  ServerOptions options_;
  DdsNode node_{domain(), true};
  Ears ears_{node_};
  ScanPublisher robot_{domain(), true, "/points", "/odom"};
  std::optional<MapStore> store_;
  std::optional<MapServer> server_;
};

TEST_F(MapServerTest, TellsWhereTheBaseIsWithoutOdometry) {
  for (std::size_t i = 0; i < 6; ++i) ASSERT_TRUE(drive_scan(i));
  const std::vector<StampedTransform> heard = transforms_heard();
  ASSERT_FALSE(heard.empty());
  EXPECT_EQ(heard.back().child, "base_link");
  EXPECT_NEAR(heard.back().time, 100 + drive().time(5), 1e-6);
  EXPECT_LT(error(heard.back().T_parent_child, drive().T_map_sensor(5) * kBaseOnSensor), 0.02);
}

TEST_F(MapServerTest, TellsWhereTheOdometryIs) {
  const Pose T_odom_map = {Eigen::AngleAxisd(1, Eigen::Vector3d::UnitZ()).toRotationMatrix(), {3, 4, 0}};
  for (std::size_t i = 0; i < 6; ++i) ASSERT_TRUE(drive_scan(i, T_odom_map));
  const std::vector<StampedTransform> heard = transforms_heard();
  ASSERT_FALSE(heard.empty());
  EXPECT_EQ(heard.back().child, "odom");
  EXPECT_LT(error(heard.back().T_parent_child, T_odom_map.inverse()), 0.05);
}

TEST_F(MapServerTest, ACloudThatLiesAboutItsSizeIsCountedAndTheNextIsUsed) {
  ASSERT_TRUE(drive_scan(0));
  DdsWriter liar(node_, "/points", sensor_msgs_msg_dds__PointCloud2__desc, Delivery::kReliable);
  server_.reset();
  while (liar.readers() == 0) server().step(0.01);
  sensor_msgs_msg_dds__PointCloud2_ lie{};
  std::string frame = kFrame;
  lie.header = header_of(100, frame);
  lie.height = 1000;
  lie.width = 1000000;
  lie.point_step = 16;
  liar.write(&lie);
  for (int i = 0; i < 200 && server().counts().damaged == 0; ++i) server().step(0.01);
  EXPECT_EQ(server().counts().damaged, 1U);
}

TEST_F(MapServerTest, AScanThatIsNotLaterIsLeftOutAndASetBackClockBeginsAnew) {
  for (std::size_t i = 0; i < 4; ++i) ASSERT_TRUE(drive_scan(i));
  EXPECT_FALSE(drive_scan(2));
  EXPECT_EQ(server().counts().not_later, 1U);
  ASSERT_TRUE(drive_scan(4));
  std::optional<ScanResult> result;
  for (std::size_t i = 5; i < 9; ++i) result = drive_scan(i, std::nullopt, -50);
  ASSERT_TRUE(result);
  EXPECT_TRUE(result->is_believed());
  EXPECT_LT(error(result->T_map_sensor, drive().T_map_sensor(8)), 0.02);
}

TEST_F(MapServerTest, APoseFromAUserIsFollowed) {
  options_.T_map_base_initial.translation.x() += 30;
  ASSERT_TRUE(drive_scan(0));
  robot_.send_initial_pose({0, "map", "", drive().T_map_sensor(1) * kBaseOnSensor});
  std::optional<ScanResult> result;
  for (std::size_t i = 1; i < 6; ++i) result = drive_scan(i);
  ASSERT_TRUE(result);
  EXPECT_TRUE(result->is_believed());
  EXPECT_LT(error(result->T_map_sensor, drive().T_map_sensor(5)), 0.02);
}

TEST_F(MapServerTest, KeepsTheMapAndThePlaceForTheNextStart) {
  for (std::size_t i = 0; i < 6; ++i) ASSERT_TRUE(drive_scan(i));
  EXPECT_EQ(command("save"), "save: done");
  EXPECT_EQ(MapHistory(path("map.evm")).versions().size(), 2U);
  server().finish(false);
  EXPECT_LT(error(read_poses(path("map.evm.pose")).poses.back().T_map_sensor,
                  drive().T_map_sensor(5) * kBaseOnSensor),
            0.02);
}

TEST_F(MapServerTest, Obeys) {
  for (std::size_t i = 0; i < 3; ++i) ASSERT_TRUE(drive_scan(i));
  EXPECT_EQ(command("pause"), "pause: done");
  const std::optional<ScanResult> paused = drive_scan(3);
  ASSERT_TRUE(paused);
  EXPECT_FALSE(paused->is_written);
  EXPECT_EQ(command("resume"), "resume: done");
  const std::optional<ScanResult> resumed = drive_scan(4);
  ASSERT_TRUE(resumed);
  EXPECT_TRUE(resumed->is_written);
  EXPECT_EQ(command("save"), "save: done");
  EXPECT_EQ(command("reset 1"), "reset 1: done");
  save_map(path("first.evm"), load_map_version(path("map.evm").string() + "@1"));
  EXPECT_TRUE(content(path("map.evm")) == content(path("first.evm")));
  EXPECT_TRUE(command("reset 77").starts_with("reset 77: failed, "));
  EXPECT_TRUE(command("dance").starts_with("dance: unknown"));
}

TEST_F(MapServerTest, GivesTheWholeMapToWhoComesLater) {
  ASSERT_TRUE(drive_scan(0));
  for (int i = 0; i < 200; ++i) {
    server().step(0.01);
    for (const DdsMessage& message : ears_.maps.take()) {
      const CloudMessage cloud =
          read_cloud_message({"/evermap/map", "sensor_msgs/PointCloud2", Wire::kCdr}, message.bytes, "map");
      std::size_t occupied = 0;
      load_map(path("map.evm")).for_each_leaf([&](VoxelKey, const Leaf& leaf) {
        occupied += leaf.occupied();
      });
      EXPECT_EQ(cloud.frame, "map");
      EXPECT_NEAR(static_cast<double>(cloud.scan.p_sensor.size()), static_cast<double>(occupied),
                  0.02 * static_cast<double>(occupied));
      return;
    }
  }
  FAIL() << "no map came";
}

TEST_F(MapServerTest, FindsTheRobotAfterAMinuteWithoutClouds) {
  for (std::size_t i = 0; i < 4; ++i) ASSERT_TRUE(drive_scan(i));
  std::optional<ScanResult> result;
  for (std::size_t i = 4; i < 10; ++i) result = drive_scan(i, std::nullopt, 60);
  ASSERT_TRUE(result);
  EXPECT_TRUE(result->is_believed());
  EXPECT_LT(error(result->T_map_sensor, drive().T_map_sensor(9)), 0.02);
}

TEST_F(MapServerTest, OdometryThatComesAfterItsCloudIsWaitedFor) {
  const Pose T_odom_map = {Eigen::Matrix3d::Identity(), {3, 4, 0}};
  for (std::size_t i = 0; i < 3; ++i) ASSERT_TRUE(drive_scan(i, T_odom_map));
  Scan scan = drive().scan(3).scan;
  scan.time = 100 + drive().time(3);
  robot_.send_cloud(scan, kFrame);
  for (int i = 0; i < 5; ++i) EXPECT_FALSE(server().step(0.01));
  robot_.send_transforms({{*scan.time + 0.01, "odom", options_.base_frame,
                           T_odom_map * drive().T_map_sensor(3) * kBaseOnSensor}},
                         false);
  const std::optional<ScanResult> result = next_result();
  ASSERT_TRUE(result);
  EXPECT_TRUE(result->is_believed());
  EXPECT_EQ(transforms_heard().back().child, "odom");
}

TEST_F(MapServerTest, OdometryMayBeginAndEndLater) {
  const Pose T_odom_map = {Eigen::Matrix3d::Identity(), {3, 4, 0}};
  for (std::size_t i = 0; i < 3; ++i) ASSERT_TRUE(drive_scan(i));
  for (std::size_t i = 3; i < 8; ++i) drive_scan(i, T_odom_map);
  EXPECT_EQ(transforms_heard().back().child, "odom");
  std::optional<ScanResult> result;
  for (std::size_t i = 8; i < 40; ++i) result = drive_scan(i);
  ASSERT_TRUE(result);
  EXPECT_TRUE(result->is_believed()) << to_string(result->reject_reason);
  EXPECT_EQ(transforms_heard().back().child, "base_link");
  EXPECT_GT(server().counts().without_odometry, 0U);
}

TEST_F(MapServerTest, AGyroscopeIsHeard) {
  std::string heard;
  for (std::size_t i = 0; i < 12; ++i) {
    server();
    for (int k = -10; k <= 1; ++k)
      robot_.send_turn_rate({100 + drive().time(i) + 0.01 * k, kFrame, Eigen::Vector3d::Zero()});
    server().step(0.1);
    const std::optional<ScanResult> result = drive_scan(i);
    ASSERT_TRUE(result);
    EXPECT_TRUE(i < 3 || result->is_believed());
  }
  for (int i = 0; i < 300 && heard.empty(); ++i) {
    server().step(0.01);
    for (const DdsMessage& message : ears_.diagnostics.take()) heard += message.bytes;
  }
  const std::size_t key = heard.find("gyroscope");
  ASSERT_NE(key, std::string::npos);
  EXPECT_EQ(heard.substr(key + 16, 4), "used") << heard.substr(key, 40);
}

TEST_F(MapServerTest, HearsTheFirstOfTwoSensorsOnOneTopic) {
  ASSERT_TRUE(drive_scan(0));
  ScanPublisher second(domain(), true, "/points", "/odom");
  while (second.listeners() == 0) server().step(0.01);
  Scan elsewhere = drive().scan(20).scan;
  elsewhere.time = 100 + drive().time(1) + 0.01;
  ASSERT_TRUE(drive_scan(1));  // lately, or the second would take its place
  second.send_cloud(elsewhere, kFrame);
  for (int i = 0; i < 50 && server().counts().foreign == 0; ++i) EXPECT_FALSE(server().step(0.01));
  EXPECT_EQ(server().counts().foreign, 1U);
  const std::optional<ScanResult> result = drive_scan(2);
  ASSERT_TRUE(result);
  EXPECT_LT(error(result->T_map_sensor, drive().T_map_sensor(2)), 0.02);
}

TEST_F(MapServerTest, ALoopOfFramesTellsNothingAndHarmsNothing) {
  server();
  robot_.send_transforms(
      {{0, "a", "b", {}}, {0, "b", "a", {}}, {0, "odom", "lidar", {}}, {0, "lidar", "odom", {}}}, true);
  for (std::size_t i = 0; i < 3; ++i) ASSERT_TRUE(drive_scan(i));
}

TEST_F(MapServerTest, SaysThatNoCloudComes) {
  server();
  std::string heard;
  for (int i = 0; i < 400 && heard.find("no cloud comes") == std::string::npos; ++i) {
    server().step(0.01);
    for (const DdsMessage& message : ears_.diagnostics.take()) heard += message.bytes;
  }
  EXPECT_NE(heard.find("no cloud comes on /points"), std::string::npos);
}

}  // namespace
}  // namespace evermap
