// SPDX-FileCopyrightText: 2026 the evermap authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <filesystem>
#include <memory>
#include <optional>
#include <string>

#include <evermap/io/cloud.hpp>
#include <evermap/io/detail/selected_scans.hpp>
#include <evermap/io/poses.hpp>

namespace evermap {

/// What a user knows of a recording better than it says.
struct ScanOptions {
  CloudOptions cloud = {};
  std::string topic = {};  ///< of a bag's clouds; empty: the only one
  ScanSelection selection = {};
  std::string reference = {};  ///< what pose_at() tells: a topic of poses, or a frame of /tf; empty: nothing
  bool is_reference_needed = true;  ///< or a bag may have none
  std::string base = {};            ///< the frame that base_pose() tells; empty: nothing
  bool is_imu_wanted = false;       ///< whether rotation_at() is to tell a gyroscope's turns
  std::string imu = {};             ///< topic of sensor_msgs/Imu; empty: the only one
  std::optional<SensorMount> mount =
      {};  ///< of the sensor on what poses are of, where the recording does not tell
};

/// Whether a path is a bag, by its name: .bag, .db3, .mcap, these with .zstd behind, or a folder that holds
/// such files.
bool is_bag(const std::filesystem::path& path);

/// Opens a folder of clouds, one cloud, or a bag: .bag of ROS 1; .db3 and .mcap of ROS 2, or a folder of
/// these. Throws FileError when there is no scan in it, or it cannot be told which of several topics is
/// meant.
std::unique_ptr<ScanSource> open_scans(const std::filesystem::path& path, const ScanOptions& options = {});

}  // namespace evermap
