// SPDX-FileCopyrightText: 2026 the evermap authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <ros_messages.h>
#include <span>
#include <string>
#include <vector>

#include <Eigen/Core>
#include <Eigen/Geometry>

#include <evermap/bags/detail/messages.hpp>
#include <evermap/ros/detail/dds.hpp>

namespace evermap {

// How our values become the C types that idlc makes of ros_messages.idl. These only look at what they are
// given: texts and sequences stay the caller's, until the message is written.

inline char* text(const std::string& value) { return const_cast<char*>(value.c_str()); }

template <class Sequence, class Item>
Sequence view_of(std::vector<Item>& items) {
  const auto size = static_cast<std::uint32_t>(items.size());
  return {size, size, items.data(), false};
}

builtin_interfaces_msg_dds__Time_ stamp_of(double time);
std_msgs_msg_dds__Header_ header_of(double time, const std::string& frame);
geometry_msgs_msg_dds__Pose_ pose_of(const Pose& pose);
geometry_msgs_msg_dds__PoseWithCovariance_ with_covariance(const Pose& pose,
                                                           const Eigen::Matrix<double, 6, 6>& covariance);

/// A value of four bytes of each point of a cloud.
struct PointField {
  std::string name;
  bool is_float = true;  ///< else an int32
};
/// Sends points, `data` holding the values of each in the order of the fields, as sensor_msgs/PointCloud2.
void send(DdsWriter& writer, double time, const std::string& frame, const std::vector<PointField>& fields,
          std::span<const std::uint8_t> data);
/// tf2_msgs/TFMessage
void send(DdsWriter& writer, const std::vector<StampedTransform>& transforms);
/// nav_msgs/Odometry, whose twist is unknown
void send(DdsWriter& writer, const StampedTransform& pose, const Eigen::Matrix<double, 6, 6>& covariance);

}  // namespace evermap
