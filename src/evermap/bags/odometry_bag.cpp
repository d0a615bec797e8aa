// SPDX-FileCopyrightText: 2026 the evermap authors
// SPDX-License-Identifier: BSD-3-Clause
#include <cmath>
#include <cstdint>
#include <string_view>

#include <evermap/bags/detail/mcap_format.hpp>
#include <evermap/bags/detail/wire_writer.hpp>
#include <evermap/bags/odometry_bag.hpp>
#include <evermap/files/file_error.hpp>
#include <evermap/io/detail/atomic_file.hpp>

namespace evermap {
namespace {

/// Definitions of message types, as MCAP wants them: the type's own, then those it is made of.
constexpr std::string_view kOdometryDefinition = R"(std_msgs/Header header
string child_frame_id
geometry_msgs/PoseWithCovariance pose
geometry_msgs/TwistWithCovariance twist
================================================================================
MSG: std_msgs/Header
builtin_interfaces/Time stamp
string frame_id
================================================================================
MSG: builtin_interfaces/Time
int32 sec
uint32 nanosec
================================================================================
MSG: geometry_msgs/PoseWithCovariance
geometry_msgs/Pose pose
float64[36] covariance
================================================================================
MSG: geometry_msgs/Pose
geometry_msgs/Point position
geometry_msgs/Quaternion orientation
================================================================================
MSG: geometry_msgs/Point
float64 x
float64 y
float64 z
================================================================================
MSG: geometry_msgs/Quaternion
float64 x
float64 y
float64 z
float64 w
================================================================================
MSG: geometry_msgs/TwistWithCovariance
geometry_msgs/Twist twist
float64[36] covariance
================================================================================
MSG: geometry_msgs/Twist
geometry_msgs/Vector3 linear
geometry_msgs/Vector3 angular
================================================================================
MSG: geometry_msgs/Vector3
float64 x
float64 y
float64 z
)";
constexpr std::string_view kTransformsDefinition = R"(geometry_msgs/TransformStamped[] transforms
================================================================================
MSG: geometry_msgs/TransformStamped
std_msgs/Header header
string child_frame_id
geometry_msgs/Transform transform
================================================================================
MSG: std_msgs/Header
builtin_interfaces/Time stamp
string frame_id
================================================================================
MSG: builtin_interfaces/Time
int32 sec
uint32 nanosec
================================================================================
MSG: geometry_msgs/Transform
geometry_msgs/Vector3 translation
geometry_msgs/Quaternion rotation
================================================================================
MSG: geometry_msgs/Vector3
float64 x
float64 y
float64 z
================================================================================
MSG: geometry_msgs/Quaternion
float64 x
float64 y
float64 z
float64 w
)";

/// MCAP's own records are like messages of ROS 1.
WireWriter packed() { return WireWriter(Wire::kRos1); }

std::string record(unsigned op, std::string_view content) {
  return packed()
      .number(static_cast<std::uint8_t>(op))
      .number<std::uint64_t>(content.size())
      .raw(content)
      .bytes();
}

/// A topic and its type, both of the same number.
std::string channel(std::uint16_t id, std::string_view topic, std::string_view type,
                    std::string_view definition) {
  return record(McapOp::kSchema, packed().number(id).text(type).text("ros2msg").text(definition).bytes()) +
         record(McapOp::kChannel,
                packed().number(id).number(id).text(topic).text("cdr").number<std::uint32_t>(0).bytes());
}

std::string message(std::uint16_t channel, std::size_t number, double time, std::string_view bytes) {
  constexpr double kNanoseconds = 1e9;
  const auto stamp = static_cast<std::uint64_t>(std::llround(time * kNanoseconds));
  return record(McapOp::kMessage, packed()
                                      .number(channel)
                                      .number(static_cast<std::uint32_t>(number))
                                      .number(stamp)
                                      .number(stamp)
                                      .raw(bytes)
                                      .bytes());
}

std::string odometry_message(const Odometry& pose, const OdometryFrames& frames) {
  WireWriter writer(Wire::kCdr);
  writer.header(pose.time, frames.frame).text(frames.child).pose(pose.T_frame_child);
  for (const double value : pose.covariance.reshaped<Eigen::RowMajor>()) writer.number(value);
  for (int i = 0; i < 6; ++i) writer.number(0.0);
  writer.number(-1.0);
  for (int i = 1; i < 36; ++i) writer.number(0.0);
  return writer.bytes();
}

std::string transform_message(const Odometry& pose, const OdometryFrames& frames) {
  return WireWriter(Wire::kCdr)
      .number<std::uint32_t>(1)
      .header(pose.time, frames.frame)
      .text(frames.child)
      .pose(pose.T_frame_child)
      .bytes();
}

}  // namespace

void write_odometry_bag(const std::filesystem::path& path, const std::vector<Odometry>& poses,
                        const OdometryFrames& frames) {
  constexpr std::uint16_t kOdometry = 1;
  constexpr std::uint16_t kTransforms = 2;
  const std::string channels =
      channel(kOdometry, kOdometryTopic, "nav_msgs/msg/Odometry", kOdometryDefinition) +
      channel(kTransforms, "/tf", "tf2_msgs/msg/TFMessage", kTransformsDefinition);
  AtomicFile file(path);
  std::uint64_t size = 0;
  const auto write = [&](std::string_view bytes) {
    file.write(bytes);
    size += bytes.size();
  };
  write(kMcapMagic);
  write(record(McapOp::kHeader, packed().text("ros2").text("evermap").bytes()));
  write(channels);
  for (std::size_t i = 0; i < poses.size(); ++i) {
    if (!(poses[i].time >= 0)) throw FileError(path, "a bag cannot hold times before 1970");
    write(message(kOdometry, i, poses[i].time, odometry_message(poses[i], frames)));
    write(message(kTransforms, i, poses[i].time, transform_message(poses[i], frames)));
  }
  write(record(McapOp::kDataEnd, packed().number<std::uint32_t>(0).bytes()));
  const std::uint64_t summary = size;
  write(channels);
  WireWriter statistics = packed();
  const auto stamp = [](double time) { return static_cast<std::uint64_t>(std::llround(time * 1e9)); };
  statistics.number<std::uint64_t>(2 * poses.size()).number<std::uint16_t>(2).number<std::uint32_t>(2);
  for (int i = 0; i < 3; ++i) statistics.number<std::uint32_t>(0);  // attachments, metadata, chunks
  statistics.number(poses.empty() ? 0 : stamp(poses.front().time));
  statistics.number(poses.empty() ? 0 : stamp(poses.back().time));
  statistics.number<std::uint32_t>(2 * (2 + 8));
  for (const std::uint16_t id : {kOdometry, kTransforms})
    statistics.number(id).number<std::uint64_t>(poses.size());
  write(record(McapOp::kStatistics, statistics.bytes()));
  write(record(McapOp::kFooter,
               packed().number(summary).number<std::uint64_t>(0).number<std::uint32_t>(0).bytes()));
  write(kMcapMagic);
  file.commit();
}

}  // namespace evermap
