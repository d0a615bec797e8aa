// SPDX-FileCopyrightText: 2026 the evermap authors
// SPDX-License-Identifier: BSD-3-Clause
#include <cmath>
#include <cstdint>
#include <initializer_list>
#include <string_view>

#include <evermap/bags/detail/mcap_format.hpp>
#include <evermap/bags/detail/wire_writer.hpp>
#include <evermap/bags/odometry_bag.hpp>
#include <evermap/files/file_error.hpp>
#include <evermap/io/detail/atomic_file.hpp>

namespace evermap {
namespace {

// Types that messages are made of, as MCAP wants them told.
constexpr std::string_view kHeader = "MSG: std_msgs/Header\nbuiltin_interfaces/Time stamp\nstring frame_id\n";
constexpr std::string_view kTime = "MSG: builtin_interfaces/Time\nint32 sec\nuint32 nanosec\n";
constexpr std::string_view kVector = "MSG: geometry_msgs/Vector3\nfloat64 x\nfloat64 y\nfloat64 z\n";
constexpr std::string_view kQuaternion =
    "MSG: geometry_msgs/Quaternion\nfloat64 x\nfloat64 y\nfloat64 z\nfloat64 w\n";
constexpr std::string_view kPoint = "MSG: geometry_msgs/Point\nfloat64 x\nfloat64 y\nfloat64 z\n";
constexpr std::string_view kPose =
    "MSG: geometry_msgs/Pose\ngeometry_msgs/Point position\ngeometry_msgs/Quaternion orientation\n";
constexpr std::string_view kPoseWithCovariance =
    "MSG: geometry_msgs/PoseWithCovariance\ngeometry_msgs/Pose pose\nfloat64[36] covariance\n";
constexpr std::string_view kTwist =
    "MSG: geometry_msgs/Twist\ngeometry_msgs/Vector3 linear\ngeometry_msgs/Vector3 angular\n";
constexpr std::string_view kTwistWithCovariance =
    "MSG: geometry_msgs/TwistWithCovariance\ngeometry_msgs/Twist twist\nfloat64[36] covariance\n";
constexpr std::string_view kTransform =
    "MSG: geometry_msgs/Transform\ngeometry_msgs/Vector3 translation\ngeometry_msgs/Quaternion rotation\n";
constexpr std::string_view kTransformStamped =
    "MSG: geometry_msgs/TransformStamped\nstd_msgs/Header header\nstring child_frame_id\n"
    "geometry_msgs/Transform transform\n";

/// A type's own fields, then the types that it is made of.
std::string definition_of(std::string_view fields, std::initializer_list<std::string_view> types) {
  constexpr std::size_t kRule = 80;
  std::string definition(fields);
  for (const std::string_view type : types) definition.append(kRule, '=').append("\n").append(type);
  return definition;
}

std::string odometry_definition() {
  return definition_of(
      "std_msgs/Header header\nstring child_frame_id\ngeometry_msgs/PoseWithCovariance pose\n"
      "geometry_msgs/TwistWithCovariance twist\n",
      {kHeader, kTime, kPoseWithCovariance, kPose, kPoint, kQuaternion, kTwistWithCovariance, kTwist,
       kVector});
}

std::string transforms_definition() {
  return definition_of("geometry_msgs/TransformStamped[] transforms\n",
                       {kTransformStamped, kHeader, kTime, kTransform, kVector, kQuaternion});
}

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

std::uint64_t nanoseconds(double time) { return static_cast<std::uint64_t>(std::llround(1e9 * time)); }

std::string message(std::uint16_t channel, std::size_t number, double time, std::string_view bytes) {
  const std::uint64_t stamp = nanoseconds(time);
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
      channel(kOdometry, kOdometryTopic, "nav_msgs/msg/Odometry", odometry_definition()) +
      channel(kTransforms, "/tf", "tf2_msgs/msg/TFMessage", transforms_definition());
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
  statistics.number<std::uint64_t>(2 * poses.size()).number<std::uint16_t>(2).number<std::uint32_t>(2);
  for (int i = 0; i < 3; ++i) statistics.number<std::uint32_t>(0);  // attachments, metadata, chunks
  statistics.number(poses.empty() ? 0 : nanoseconds(poses.front().time));
  statistics.number(poses.empty() ? 0 : nanoseconds(poses.back().time));
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
