// SPDX-FileCopyrightText: 2026 the evermap authors
// SPDX-License-Identifier: BSD-3-Clause
#include <algorithm>
#include <cmath>
#include <iterator>

#include <evermap/ros/detail/idl_types.hpp>

namespace evermap {
namespace {

geometry_msgs_msg_dds__Quaternion_ quaternion_of(const Eigen::Matrix3d& rotation) {
  const Eigen::Quaterniond q(rotation);
  return {q.x(), q.y(), q.z(), q.w()};
}

}  // namespace

builtin_interfaces_msg_dds__Time_ stamp_of(double time) {
  constexpr double kNanoseconds = 1e9;
  const double seconds = std::floor(time);
  return {static_cast<std::int32_t>(seconds), static_cast<std::uint32_t>((time - seconds) * kNanoseconds)};
}

std_msgs_msg_dds__Header_ header_of(double time, const std::string& frame) {
  return {stamp_of(time), text(frame)};
}

geometry_msgs_msg_dds__Pose_ pose_of(const Pose& pose) {
  const Eigen::Vector3d& t = pose.translation;
  return {{t.x(), t.y(), t.z()}, quaternion_of(pose.rotation)};
}

geometry_msgs_msg_dds__PoseWithCovariance_ with_covariance(const Pose& pose,
                                                           const Eigen::Matrix<double, 6, 6>& covariance) {
  geometry_msgs_msg_dds__PoseWithCovariance_ message{pose_of(pose), {}};
  std::copy_n(covariance.data(), covariance.size(), std::begin(message.covariance));  // symmetric
  return message;
}

void send(DdsWriter& writer, double time, const std::string& frame, const std::vector<PointField>& fields,
          std::span<const std::uint8_t> data) {
  constexpr std::uint8_t kInt32 = 5;
  constexpr std::uint8_t kFloat32 = 7;
  std::vector<sensor_msgs_msg_dds__PointField_> entries;
  entries.reserve(fields.size());
  std::uint32_t step = 0;  // [bytes]
  for (const PointField& field : fields) {
    entries.push_back({text(field.name), step, field.is_float ? kFloat32 : kInt32, 1});
    step += 4;
  }
  sensor_msgs_msg_dds__PointCloud2_ message{};
  message.header = header_of(time, frame);
  message.height = 1;
  message.width = static_cast<std::uint32_t>(data.size()) / std::max(step, 1U);
  message.fields = view_of<decltype(message.fields)>(entries);
  message.point_step = step;
  message.row_step = static_cast<std::uint32_t>(data.size());
  message.data = {message.row_step, message.row_step, const_cast<std::uint8_t*>(data.data()), false};
  writer.write(&message);
}

void send(DdsWriter& writer, const std::vector<StampedTransform>& transforms) {
  std::vector<geometry_msgs_msg_dds__TransformStamped_> entries;
  entries.reserve(transforms.size());
  for (const StampedTransform& transform : transforms) {
    const Eigen::Vector3d& t = transform.T_parent_child.translation;
    entries.push_back({header_of(transform.time, transform.parent),
                       text(transform.child),
                       {{t.x(), t.y(), t.z()}, quaternion_of(transform.T_parent_child.rotation)}});
  }
  tf2_msgs_msg_dds__TFMessage_ message{};
  message.transforms = view_of<decltype(message.transforms)>(entries);
  writer.write(&message);
}

void send(DdsWriter& writer, const StampedTransform& pose, const Eigen::Matrix<double, 6, 6>& covariance) {
  nav_msgs_msg_dds__Odometry_ message{};
  message.header = header_of(pose.time, pose.parent);
  message.child_frame_id = text(pose.child);
  message.pose = with_covariance(pose.T_parent_child, covariance);
  message.twist.covariance[0] = -1;
  writer.write(&message);
}

}  // namespace evermap
