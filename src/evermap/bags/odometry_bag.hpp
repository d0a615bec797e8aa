// SPDX-FileCopyrightText: 2026 the evermap authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include <Eigen/Core>

#include <evermap/geometry/pose.hpp>

namespace evermap {

/// A pose that was found, and how well it is known.
struct Odometry {
  double time = 0;  ///< [s]
  Pose T_frame_child;
  /// [m, rad] of (translation, rotation about the child) in the frame's axes.
  Eigen::Matrix<double, 6, 6> covariance = Eigen::Matrix<double, 6, 6>::Zero();
};

struct OdometryFrames {
  std::string frame = "map";
  std::string child = "lidar";
};

inline constexpr const char* kOdometryTopic = "/evermap/odometry";

/// Writes a bag of ROS 2, an MCAP file with nav_msgs/Odometry on kOdometryTopic and the same as transforms on
/// /tf, atomically. The twist is unknown: its covariance begins with -1. Throws FileError.
void write_odometry_bag(const std::filesystem::path& path, const std::vector<Odometry>& poses,
                        const OdometryFrames& frames);

}  // namespace evermap
