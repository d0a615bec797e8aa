// SPDX-FileCopyrightText: 2026 the evermap authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <filesystem>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include <evermap/bags/detail/bag_reader.hpp>
#include <evermap/io/detail/cloud_notes.hpp>
#include <evermap/scan/scan.hpp>

namespace evermap {

/// What a message is good for here.
enum class MessageKind {
  kOther,
  kCloud,       ///< sensor_msgs/PointCloud2
  kLivoxCloud,  ///< livox_ros_driver/CustomMsg, livox_ros_driver2/CustomMsg
  kTransforms,  ///< tf2_msgs/TFMessage, tf/tfMessage
  kPoses,       ///< nav_msgs/Odometry and Path, geometry_msgs/PoseStamped, PoseWithCovarianceStamped and
                ///< TransformStamped
  kImu,         ///< sensor_msgs/Imu
};
MessageKind kind_of(std::string_view type);
inline bool is_cloud(const BagTopic& topic) {
  const MessageKind kind = kind_of(topic.type);
  return kind == MessageKind::kCloud || kind == MessageKind::kLivoxCloud;
}

/// A scan with its time, and the frame of its points.
struct CloudMessage {
  std::string frame;
  Scan scan;
  CloudNotes notes;
};

/// Reads a message of a topic of clouds. Throws FileError naming `bag` when it is damaged, or no cloud of
/// points.
CloudMessage read_cloud_message(const BagTopic& topic, std::string_view bytes,
                                const std::filesystem::path& bag);

/// A value of the points of a PointCloud2, as its message says.
struct CloudField {
  std::string name;
  Scalar type = Scalar::kFloat32;
};
/// The frame and fields of a cloud, without reading its points.
struct CloudHead {
  std::string frame;
  std::uint32_t width = 0, height = 0;
  std::vector<CloudField> fields;
};
CloudHead read_cloud_head(const BagTopic& topic, std::string_view bytes, const std::filesystem::path& bag);

/// T_parent_child at a moment.
struct StampedTransform {
  double time = 0;  ///< [s]
  std::string parent;
  std::string child;  ///< empty when the message does not name it
  Pose T_parent_child;
};

/// How fast a gyroscope turns.
struct TurnRate {
  double time = 0;  ///< [s]
  std::string frame;
  Eigen::Vector3d rate = Eigen::Vector3d::Zero();  ///< [rad/s] about the frame's axes
};
/// What a message of a kImu topic tells; nothing when it is damaged, or its rates are no numbers.
std::optional<TurnRate> read_turn_rate(const BagTopic& topic, std::string_view bytes);

/// What a message of transforms or poses tells; nothing when it is damaged.
std::vector<StampedTransform> read_transforms(const BagTopic& topic, std::string_view bytes);

}  // namespace evermap
