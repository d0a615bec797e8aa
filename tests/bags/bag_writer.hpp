// SPDX-FileCopyrightText: 2026 the evermap authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "files/file_fixture.hpp"
#include <evermap/bags/detail/wire_writer.hpp>
#include <evermap/geometry/pose.hpp>

namespace evermap {

struct CloudPoint {
  float x, y, z;
  float time;  ///< [s] since the stamp
};
/// A PointCloud2 of x y z and time, with a gap between and behind them.
std::string cloud_message(Wire wire, double time, const std::string& frame,
                          const std::vector<CloudPoint>& points, std::endian order = std::endian::little);
/// A TFMessage.
std::string transform_message(Wire wire, double time, const std::string& parent, const std::string& child,
                              const Pose& T_parent_child);
std::string odometry_message(Wire wire, double time, const std::string& frame, const std::string& child,
                             const Pose& T_frame_child);

/// An Imu of which only the rates [rad/s] are told.
std::string imu_message(Wire wire, double time, const std::string& frame, const Eigen::Vector3d& rate);

struct WrittenMessage {
  std::string topic;
  std::string type;  ///< package/Type
  double time;       ///< [s]
  std::string bytes;
};

struct BagStyle {
  std::string compression = "none";
  bool has_index = true;
  std::size_t messages_per_chunk = 3;
};
std::string ros1_bag(const std::vector<WrittenMessage>& messages, const BagStyle& style = {});
std::string mcap_bag(const std::vector<WrittenMessage>& messages, Wire wire, const BagStyle& style = {});
/// Writes a file of rosbag2, with each message compressed if the style says zstd.
void write_sqlite_bag(const std::filesystem::path& path, const std::vector<WrittenMessage>& messages,
                      const BagStyle& style = {});

std::string compressed(const std::string& bytes, const std::string& compression);

}  // namespace evermap
