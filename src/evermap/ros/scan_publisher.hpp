// SPDX-FileCopyrightText: 2026 the evermap authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstddef>
#include <memory>
#include <string>
#include <vector>

#include <evermap/bags/detail/messages.hpp>
#include <evermap/scan/scan.hpp>

namespace evermap {

/// Sends what a robot sends, on topics of ROS 2: to play a recording, or in a test. Not thread safe.
class ScanPublisher {
 public:
  /// In a domain of ROS; `is_local`: to this machine alone. Throws DdsError when the network cannot be used.
  ScanPublisher(unsigned domain, bool is_local, const std::string& points, const std::string& odometry);
  ~ScanPublisher();

  /// sensor_msgs/PointCloud2 with the points' times, if they have any. REQUIRES: the scan has a time.
  void send_cloud(const Scan& scan, const std::string& frame);
  /// To /tf, or to /tf_static, where all that were sent are kept for those who come later.
  void send_transforms(const std::vector<StampedTransform>& transforms, bool is_static);
  void send_odometry(const StampedTransform& pose);
  void send_turn_rate(const TurnRate& rate);  ///< sensor_msgs/Imu to /imu
  void send_clock(double time);
  /// geometry_msgs/PoseWithCovarianceStamped to /initialpose
  void send_initial_pose(const StampedTransform& pose);

  /// What comes on /tf from others, within `seconds`; returns as soon as something does.
  std::vector<StampedTransform> listen(double seconds);

  /// How many listen to the clouds.
  std::size_t listeners() const;

 private:
  class Topics;

  std::unique_ptr<Topics> topics_;
};

}  // namespace evermap
