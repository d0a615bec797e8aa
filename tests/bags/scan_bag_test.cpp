// SPDX-FileCopyrightText: 2026 the evermap authors
// SPDX-License-Identifier: BSD-3-Clause
#include <algorithm>
#include <cmath>
#include <functional>
#include <sys/resource.h>

#include <Eigen/Geometry>

#include "bags/bag_writer.hpp"
#include <evermap/bags/scan_bag.hpp>

namespace evermap {
namespace {

constexpr double kStart = 1700000000.5;  // [s]
constexpr std::size_t kClouds = 8;

Pose moved(double x, double yaw = 0) {
  return {Eigen::AngleAxisd(yaw, Eigen::Vector3d::UnitZ()).toRotationMatrix(), {x, 0, 0}};
}

std::vector<CloudPoint> points_of(std::size_t cloud) {
  const auto x = static_cast<float>(cloud);
  return {{x, 1, 2, 0}, {x, -3.5F, 4, 0.05F}, {0, 0, 0, 0.07F}, {x, kNaN, 4, 0.08F}, {x, 5, 6, 0.1F}};
}

/// A drive along x at 10 m/s: 8 clouds of a sensor 1 m above base_link, odometry at 20 Hz as transform and as
/// message.
std::vector<WrittenMessage> drive(Wire wire) {
  std::vector<WrittenMessage> messages;
  const Pose T_base_sensor{Eigen::Matrix3d::Identity(), {0, 0, 1}};
  messages.push_back({"/tf_static", "tf2_msgs/TFMessage", kStart,
                      transform_message(wire, kStart, "base_link", "lidar", T_base_sensor)});
  for (std::size_t i = 0; i < 2 * kClouds + 4; ++i) {
    const double time = kStart + 0.05 * static_cast<double>(i);
    const Pose T_odom_base = moved(10 * (time - kStart));
    if (i % 2 == 0 && i / 2 < kClouds)
      messages.push_back(
          {"/points", "sensor_msgs/PointCloud2", time, cloud_message(wire, time, "lidar", points_of(i / 2))});
    messages.push_back(
        {"/tf", "tf2_msgs/TFMessage", time, transform_message(wire, time, "odom", "base_link", T_odom_base)});
    messages.push_back(
        {"/odom", "nav_msgs/Odometry", time, odometry_message(wire, time, "odom", "base_link", T_odom_base)});
  }
  return messages;
}

struct Container {
  std::string name;  ///< of the file
  Wire wire;
  std::function<void(const std::filesystem::path&, const std::vector<WrittenMessage>&)> write;
};

void write_bytes(const std::filesystem::path& path, const std::string& bytes) {
  std::ofstream(path, std::ios::binary).write(bytes.data(), static_cast<std::streamsize>(bytes.size()));
}

std::vector<Container> containers() {
  using Messages = std::vector<WrittenMessage>;
  using Path = std::filesystem::path;
  std::vector<Container> all;
  for (const bool has_index : {true, false}) {
    const std::string suffix = has_index ? "" : "_no_index";
    for (const std::string compression : {"none", "bz2", "lz4"}) {
      const BagStyle style{compression, has_index, 3};
      all.push_back(
          {compression + suffix + ".bag", Wire::kRos1, [=](const Path& path, const Messages& messages) {
             write_bytes(path, ros1_bag(messages, style));
           }});
    }
    for (const Wire wire : {Wire::kRos1, Wire::kCdr}) {
      for (const std::string compression : {"none", "lz4", "zstd", "no_chunks"}) {
        const bool has_chunks = compression != "no_chunks";
        const BagStyle style{has_chunks ? compression : "none", has_index, has_chunks ? 3U : 1U};
        all.push_back({compression + suffix + (wire == Wire::kCdr ? "_cdr.mcap" : "_ros1.mcap"), wire,
                       [=](const Path& path, const Messages& messages) {
                         write_bytes(path, mcap_bag(messages, wire, style));
                       }});
      }
    }
  }
  for (const std::string compression : {"none", "zstd"}) {
    const BagStyle style{compression, true, 1};
    all.push_back({compression + ".db3", Wire::kCdr, [=](const Path& path, const Messages& messages) {
                     write_sqlite_bag(path, messages, style);
                   }});
  }
  const auto compressed_file = [](const Path& path, const std::string& bytes) {
    write_bytes(path, compressed(bytes, "zstd"));
  };
  all.push_back({"whole.mcap.zstd", Wire::kCdr, [=](const Path& path, const Messages& messages) {
                   compressed_file(path, mcap_bag(messages, Wire::kCdr));
                 }});
  all.push_back({"whole.db3.zstd", Wire::kCdr, [=](const Path& path, const Messages& messages) {
                   const Path plain = path.parent_path() / "plain";
                   write_sqlite_bag(plain, messages);
                   std::ifstream stream(plain, std::ios::binary);
                   compressed_file(path, {std::istreambuf_iterator<char>(stream), {}});
                   std::filesystem::remove(plain);
                 }});
  const auto split = [](const Path& path, const Messages& messages, const std::string& extension,
                        const auto& write) {
    std::filesystem::create_directory(path);
    constexpr std::size_t kParts = 12;  // so that 10 follows 9
    const std::size_t size = (messages.size() + kParts - 1) / kParts;
    for (std::size_t part = 0; part * size < messages.size(); ++part) {
      const auto begin = messages.begin() + static_cast<std::ptrdiff_t>(part * size);
      const auto end =
          messages.begin() + static_cast<std::ptrdiff_t>(std::min((part + 1) * size, messages.size()));
      write(path / ("part_" + std::to_string(part) + extension), Messages(begin, end));
    }
    write_bytes(path / "metadata.yaml", "rosbag2_bagfile_information:");
  };
  all.push_back({"split_db3", Wire::kCdr, [=](const Path& path, const Messages& messages) {
                   split(path, messages, ".db3",
                         [](const Path& file, const Messages& part) { write_sqlite_bag(file, part); });
                 }});
  all.push_back({"split_mcap", Wire::kCdr, [=](const Path& path, const Messages& messages) {
                   split(path, messages, ".mcap", [](const Path& file, const Messages& part) {
                     write_bytes(file, mcap_bag(part, Wire::kCdr));
                   });
                 }});
  return all;
}

class ScanBagTest : public FileTest {
 protected:
  std::filesystem::path make_bag(const Wire wire = Wire::kRos1) {
    return wire == Wire::kRos1 ? make("drive.bag", ros1_bag(drive(wire)))
                               : make("drive.mcap", mcap_bag(drive(wire), wire));
  }
  std::filesystem::path make_bag_of(const std::vector<WrittenMessage>& messages) {
    return make("some.bag", ros1_bag(messages));
  }
};

TEST_F(ScanBagTest, EveryContainerGivesTheSameScans) {
  for (const Container& container : containers()) {
    SCOPED_TRACE(container.name);
    container.write(path(container.name), drive(container.wire));
    ASSERT_TRUE(is_bag(path(container.name)));
    const auto scans = open_scans(path(container.name), {.reference = "odom"});
    EXPECT_EQ(scans->size(), kClouds);
    for (std::size_t i = 0; i < kClouds; ++i) {
      const std::optional<Scan> scan = scans->next();
      ASSERT_TRUE(scan) << i;
      const auto x = static_cast<double>(i);
      EXPECT_EQ(scan->p_sensor, (std::vector<Eigen::Vector3d>{{x, 1, 2}, {x, -3.5, 4}, {x, 5, 6}}));
      ASSERT_EQ(scan->time_offset.size(), 3U);
      EXPECT_NEAR(scan->time_offset.back(), 0.1, 1e-6);
      EXPECT_EQ(scan->dropped_at_origin, 1U);
      EXPECT_EQ(scan->dropped_not_finite, 1U);
      const double begin = kStart + 0.1 * x;
      EXPECT_NEAR(scan->time.value_or(0), begin + 0.1, 1e-6);  // the points count from the stamp
      const std::optional<Pose> T_odom_sensor = scans->pose_at(begin + 0.07);
      ASSERT_TRUE(T_odom_sensor) << i;
      EXPECT_NEAR((T_odom_sensor->translation - Eigen::Vector3d(10 * (begin + 0.07 - kStart), 0, 1)).norm(),
                  0, 1e-5);
    }
    EXPECT_FALSE(scans->next());
    const bool is_cut_off = container.name.ends_with("no_index.bag");
    EXPECT_EQ(scans->remarks().size(), is_cut_off ? 1U : 0U);
  }
}

TEST_F(ScanBagTest, APartIsSelected) {
  const std::filesystem::path bag = make_bag();
  const auto first_x = [&](const ScanSelection& selection) {
    ScanOptions options;
    options.selection = selection;
    const auto scans = open_scans(bag, options);
    std::vector<double> x;
    while (const std::optional<Scan> scan = scans->next()) {
      x.push_back(scan->p_sensor.front().x());
      EXPECT_EQ(static_cast<double>(scans->index()), x.back());
    }
    return x;
  };
  EXPECT_EQ(first_x({}).size(), kClouds);
  EXPECT_EQ(first_x({.start = 0.2}), (std::vector<double>{2, 3, 4, 5, 6, 7}));
  EXPECT_EQ(first_x({.start = 0.2, .duration = 0.3}), (std::vector<double>{2, 3, 4, 5}));
  EXPECT_EQ(first_x({.start = 0.2, .every = 2}), (std::vector<double>{2, 4, 6}));
}

TEST_F(ScanBagTest, PosesComeFromATopicAsFromAFrame) {
  for (const std::string reference : {"odom", "/odom"}) {
    const auto scans = open_scans(make_bag(), {.reference = reference});
    const std::optional<Scan> scan = scans->next();
    ASSERT_TRUE(scan);
    const std::optional<Pose> T_odom_sensor = scans->pose_at(scan->time.value_or(0));
    ASSERT_TRUE(T_odom_sensor) << reference;
    EXPECT_NEAR((T_odom_sensor->translation - Eigen::Vector3d(1, 0, 1)).norm(), 0, 1e-5) << reference;
    EXPECT_TRUE(scans->remarks().empty());
  }
}

/// The drive with a gyroscope, which lies on its side on the sensor and turns about its own x axis, upwards.
std::vector<WrittenMessage> drive_with_gyroscope(Wire wire, double rate, double clock = 0,
                                                 const std::string& frame = "imu") {
  std::vector<WrittenMessage> messages = drive(wire);
  const Eigen::Matrix3d R_lidar_imu =
      Eigen::AngleAxisd(-M_PI / 2, Eigen::Vector3d::UnitY()).toRotationMatrix();
  messages.push_back({"/tf_static", "tf2_msgs/TFMessage", kStart,
                      transform_message(wire, kStart, "lidar", "imu", {R_lidar_imu, {0, 0, 0}})});
  for (int i = 0; i < 110; ++i) {
    const double time = kStart + 0.01 * i;
    messages.push_back(
        {"/imu", "sensor_msgs/Imu", time, imu_message(wire, time + clock, frame, {rate, 0, 0})});
  }
  std::stable_sort(messages.begin(), messages.end(),
                   [](const auto& a, const auto& b) { return a.time < b.time; });
  return messages;
}

TEST_F(ScanBagTest, AGyroscopeTellsTurnsInTheSensorsAxes) {
  constexpr double kRate = 0.5;  // [rad/s]
  for (const Wire wire : {Wire::kRos1, Wire::kCdr}) {
    const std::vector<WrittenMessage> messages = drive_with_gyroscope(wire, kRate);
    const auto scans = open_scans(wire == Wire::kRos1 ? make("gyro.bag", ros1_bag(messages))
                                                      : make("gyro.mcap", mcap_bag(messages, wire)),
                                  {.is_imu_wanted = true});
    std::optional<Eigen::Matrix3d> last;
    std::size_t count = 0;
    while (const std::optional<Scan> scan = scans->next()) {
      const std::optional<Eigen::Matrix3d> now = scans->rotation_at(*scan->time);
      ASSERT_TRUE(now);
      if (last) {
        const Eigen::AngleAxisd turn(last->transpose() * *now);
        EXPECT_NEAR(turn.angle(), 0.1 * kRate, 1e-4);
        EXPECT_NEAR(turn.axis().z(), 1, 1e-6);
      }
      last = now;
      ++count;
    }
    EXPECT_EQ(count, kClouds);
    EXPECT_TRUE(scans->remarks().empty());
  }
}

TEST_F(ScanBagTest, AGyroscopeThatCannotBeUsedIsNamed) {
  const auto remark_on = [&](const std::vector<WrittenMessage>& messages) {
    const auto scans = open_scans(make_bag_of(messages), {.is_imu_wanted = true});
    while (const std::optional<Scan> scan = scans->next()) EXPECT_FALSE(scans->rotation_at(*scan->time));
    return scans->remarks().empty() ? std::string() : scans->remarks().front();
  };
  EXPECT_NE(remark_on(drive_with_gyroscope(Wire::kRos1, 1, -1e6)).find("clock"), std::string::npos);
  EXPECT_NE(remark_on(drive_with_gyroscope(Wire::kRos1, 1, 0, "loose")).find("how the gyroscope (loose)"),
            std::string::npos);
  EXPECT_THROW(open_scans(make_bag(), {.is_imu_wanted = true, .imu = "/imu"}), FileError);
}

TEST_F(ScanBagTest, WithoutAPlaceOfTheSensorItIsSaidThatPosesWereTakenForItsOwn) {
  std::vector<WrittenMessage> messages = drive(Wire::kRos1);
  messages.erase(messages.begin());  // /tf_static
  const auto scans = open_scans(make_bag_of(messages), {.reference = "/odom"});
  const std::optional<Scan> scan = scans->next();
  ASSERT_TRUE(scan);
  EXPECT_NEAR(scans->pose_at(*scan->time).value_or(Pose{}).translation.z(), 0, 1e-9);
  ASSERT_EQ(scans->remarks().size(), 1U);
  EXPECT_NE(scans->remarks().front().find("taken for the sensor's"), std::string::npos);
}

TEST_F(ScanBagTest, WhatIsNotThereIsNamed) {
  const std::filesystem::path bag = make_bag();
  file_error(bag, "has no clouds on /scan; it has /points", [&] { open_scans(bag, {.topic = "/scan"}); });
  std::vector<WrittenMessage> messages = drive(Wire::kRos1);
  messages.push_back({"/rear", "sensor_msgs/PointCloud2", kStart + 2,
                      cloud_message(Wire::kRos1, kStart + 2, "rear", points_of(0))});
  const std::filesystem::path two = make_bag_of(messages);
  file_error(two, "has clouds on /points, /rear; choose one by --topic", [&] { open_scans(two); });
  EXPECT_EQ(open_scans(two, {.topic = "/rear"})->size(), 1U);
  const std::filesystem::path poses_only = make_bag_of({messages[1 + 1]});
  file_error(poses_only, "has no topic of point clouds", [&] { open_scans(poses_only); });
  const std::filesystem::path clouds_only = make_bag_of({messages[1]});
  file_error(clouds_only, "has neither a topic of poses named odom",
             [&] { open_scans(clouds_only, {.reference = "odom"}); });
  // A frame that /tf does not know has no pose.
  const auto scans = open_scans(bag, {.reference = "earth"});
  const std::optional<Scan> scan = scans->next();
  ASSERT_TRUE(scan);
  EXPECT_FALSE(scans->pose_at(*scan->time));
}

/// Reads all that can be read. What goes wrong must be one line that begins with the path.
std::size_t read_all(const std::filesystem::path& bag) {
  std::size_t clouds = 0;
  try {
    const auto scans = open_scans(bag, {.reference = "odom"});
    while (scans->next()) ++clouds;
    EXPECT_TRUE(clouds == kClouds || !scans->remarks().empty());
  } catch (const FileError& error) {
    const std::string_view what = error.what();
    EXPECT_TRUE(what.starts_with(bag.string())) << what;
    EXPECT_EQ(what.find('\n'), std::string_view::npos) << what;
  }
  return clouds;
}

TEST_F(ScanBagTest, CutOffAnywhereItIsReadAsFarAsItGoes) {
  const std::string ros1 = ros1_bag(drive(Wire::kRos1), {"none", false, 3});
  const std::string mcap = mcap_bag(drive(Wire::kCdr), Wire::kCdr, {"zstd", false, 3});
  std::size_t before = 0;
  for (std::size_t size = 1; size < ros1.size(); size += 3) {
    const std::size_t clouds = read_all(make("cut.bag", ros1.substr(0, size)));
    EXPECT_GE(clouds, before) << size;
    before = clouds;
  }
  EXPECT_EQ(before, kClouds);
  before = 0;
  for (std::size_t size = 1; size < mcap.size(); ++size) {
    const std::size_t clouds = read_all(make("cut.mcap", mcap.substr(0, size)));
    EXPECT_GE(clouds, before) << size;
    before = clouds;
  }
  EXPECT_EQ(before, kClouds);
  write_sqlite_bag(path("whole.db3"), drive(Wire::kCdr));
  const std::string sqlite = content(path("whole.db3"));
  for (std::size_t size = 1; size < sqlite.size(); size += 97)
    read_all(make("cut.db3", sqlite.substr(0, size)));
}

TEST_F(ScanBagTest, NoValueOfAnyFieldDoesHarm) {
  const auto try_all = [&](const std::string& name, const std::string& bytes, std::size_t step) {
    for (std::size_t at = 0; at + 4 <= bytes.size(); at += step) {
      for (const char value : {'\0', '\xff', '\x7f'}) {
        std::string changed = bytes;
        changed.replace(at, 4, std::string(4, value));
        SCOPED_TRACE(name + " at " + std::to_string(at));
        try {
          const auto scans = open_scans(make(name, changed), {.reference = "odom"});
          while (scans->next()) {
          }
        } catch (const FileError& error) {
          EXPECT_EQ(std::string_view(error.what()).find('\n'), std::string_view::npos) << error.what();
        }
      }
    }
  };
  std::vector<WrittenMessage> few = drive(Wire::kRos1);
  few.resize(5);
  try_all("few.bag", ros1_bag(few), 1);
  few = drive(Wire::kCdr);
  few.resize(5);
  try_all("few.mcap", mcap_bag(few, Wire::kCdr), 1);
  try_all("packed.mcap", mcap_bag(few, Wire::kCdr, {"lz4", true, 3}), 1);
  write_sqlite_bag(path("few.db3"), few);
  try_all("changed.db3", content(path("few.db3")), 37);
}

/// Its index promises many clouds, and its first chunk is damaged.
/// [bytes] that this process ever took.
std::size_t peak_memory() {
  rusage usage{};
  ::getrusage(RUSAGE_SELF, &usage);
  return static_cast<std::size_t>(usage.ru_maxrss) * 1024;
}

TEST_F(ScanBagTest, AnyNumberOfCloudsTakesTheMemoryOfAChunk) {
#ifdef __has_feature
#if __has_feature(address_sanitizer)
  GTEST_SKIP() << "the sanitizer keeps what was given back";
#endif
#endif
  constexpr std::size_t kParts = 40;
  constexpr std::size_t kCloudsOfPart = 10;
  constexpr std::size_t kPoints = 20000;
  const std::vector<CloudPoint> points(kPoints, {1, 2, 3, 0.05F});
  std::filesystem::create_directory(path("parts"));
  for (std::size_t part = 0; part < kParts; ++part) {
    std::vector<WrittenMessage> messages;
    for (std::size_t i = 0; i < kCloudsOfPart; ++i) {
      const double time = kStart + 0.1 * static_cast<double>(kCloudsOfPart * part + i);
      messages.push_back(
          {"/points", "sensor_msgs/PointCloud2", time, cloud_message(Wire::kCdr, time, "lidar", points)});
    }
    make("parts/part_" + std::to_string(part) + ".mcap", mcap_bag(messages, Wire::kCdr, {"zstd", true, 3}));
  }
  const std::size_t before = peak_memory();
  const auto scans = open_scans(path("parts"));
  std::size_t count = 0;
  while (scans->next()) ++count;
  EXPECT_EQ(count, kParts * kCloudsOfPart);
  constexpr std::size_t kMiB = std::size_t{1} << 20;
  EXPECT_LT(peak_memory() - before, 16 * kMiB);  // of 200 MiB that are in the bag
}

TEST_F(ScanBagTest, ABagThatIsDamagedFromTheStartIsRefusedOnce) {
  std::vector<WrittenMessage> many;
  for (int i = 0; i < 20; ++i) {
    for (const WrittenMessage& message : drive(Wire::kCdr)) many.push_back(message);
  }
  std::string bytes = mcap_bag(many, Wire::kCdr, {"none", true, 4});
  bytes[bytes.find("sensor_msgs")] = 'S';  // within the first chunk, whose checksum then does not fit
  const auto scans =
      open_scans(make("damaged.mcap", bytes), {.reference = "odom", .is_reference_needed = false});
  EXPECT_GT(scans->size(), 20U);
  file_error(path("damaged.mcap"), "another checksum than it says", [&] { scans->next(); });
  EXPECT_FALSE(scans->next());
}

TEST_F(ScanBagTest, NoBagOfItsKindIsRefused) {
  for (const std::string name : {"a.bag", "a.mcap", "a.db3"}) {
    make(name, "something else, and rather long, so that no header is cut off");
    file_error(path(name), name == "a.db3" ? "cannot be read as a bag" : "is no ",
               [&] { open_scans(path(name)); });
    file_error(path("none-" + name), "No such file", [&] { open_scans(path("none-" + name)); });
  }
}

TEST_F(ScanBagTest, TimesOfPointsPlaceTheScan) {
  struct Case {
    float first, last;    // [s] as the points say
    double stamp, ended;  // [s]
  };
  const double t = kStart;
  for (const Case& now : {Case{0, 0.1F, t, t + 0.1}, Case{-0.1F, 0, t, t}, Case{-0.05F, 0.05F, t, t + 0.05},
                          Case{5000, 5000.125F, t, t + 0.125}}) {
    const std::filesystem::path bag = make_bag_of(
        {{"/points", "sensor_msgs/PointCloud2", t,
          cloud_message(Wire::kRos1, now.stamp, "lidar", {{1, 2, 3, now.first}, {4, 5, 6, now.last}})}});
    const std::optional<Scan> scan = open_scans(bag)->next();
    ASSERT_TRUE(scan);
    EXPECT_NEAR(scan->time.value_or(0), now.ended, 1e-6) << now.first;
  }
}

TEST_F(ScanBagTest, AMessageWhoseSizesLieIsNamed) {
  std::string cloud = cloud_message(Wire::kRos1, kStart, "lidar", points_of(0));
  const std::size_t width = 4 + 8 + 4 + 5 + 4;  // [bytes] of the header and the height
  cloud.replace(width, 4, bytes_of<std::uint32_t>({1000000}));
  const std::filesystem::path bag = make_bag_of({{"/points", "sensor_msgs/PointCloud2", kStart, cloud}});
  file_error(bag, "has 120 bytes of points where its sizes say 24000000", [&] { open_scans(bag)->next(); });
}

TEST_F(ScanBagTest, BigEndianPointsAreRead) {
  const std::string cloud = cloud_message(Wire::kCdr, kStart, "lidar", points_of(3), std::endian::big);
  const std::filesystem::path bag =
      make("big.mcap", mcap_bag({{"/points", "sensor_msgs/PointCloud2", kStart, cloud}}, Wire::kCdr));
  const std::optional<Scan> scan = open_scans(bag)->next();
  ASSERT_TRUE(scan);
  EXPECT_EQ(scan->p_sensor, (std::vector<Eigen::Vector3d>{{3, 1, 2}, {3, -3.5, 4}, {3, 5, 6}}));
}

TEST_F(ScanBagTest, LivoxsOwnMessageIsRead) {
  for (const Wire wire : {Wire::kRos1, Wire::kCdr}) {
    WireWriter message(wire);
    message.header(kStart, "livox").number<std::uint64_t>(1700000000500000000).number<std::uint32_t>(3);
    message.number<std::uint8_t>(1).raw("abc").number<std::uint32_t>(3);
    for (std::uint32_t i = 0; i < 3; ++i) {
      const auto x = static_cast<float>(i + 1);
      message.number<std::uint32_t>(i * 50000000).number(x).number(2 * x).number(3 * x);
      message.number<std::uint8_t>(100).number<std::uint8_t>(0).number(static_cast<std::uint8_t>(i));
    }
    const std::filesystem::path bag =
        make("livox.mcap",
             mcap_bag({{"/livox/lidar", "livox_ros_driver2/CustomMsg", kStart, message.bytes()}}, wire));
    const std::optional<Scan> scan = open_scans(bag)->next();
    ASSERT_TRUE(scan);
    EXPECT_EQ(scan->p_sensor, (std::vector<Eigen::Vector3d>{{1, 2, 3}, {2, 4, 6}, {3, 6, 9}}));
    EXPECT_NEAR(scan->time_offset.at(1), 0.05, 1e-6);
    EXPECT_NEAR(scan->time.value_or(0), kStart + 0.1, 1e-6);
  }
}

}  // namespace
}  // namespace evermap
