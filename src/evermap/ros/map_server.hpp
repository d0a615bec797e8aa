// SPDX-FileCopyrightText: 2026 the evermap authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstddef>
#include <filesystem>
#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include <evermap/history/map_store.hpp>
#include <evermap/maintenance/map_maintainer.hpp>
#include <evermap/ros/diagnosis.hpp>

namespace evermap {

/// How a robot's node is set up.
struct ServerOptions {
  unsigned domain = 0;    ///< of ROS
  bool is_local = false;  ///< speak with this machine alone
  std::string name = "evermap";
  std::string points = "/points";   ///< topic of the clouds
  std::string odometry = "/odom";   ///< topic of nav_msgs/Odometry, if /tf does not tell
  std::string imu = "/imu";         ///< topic of sensor_msgs/Imu, of use without odometry
  std::string odom_frame = "odom";  ///< frame of the odometry in /tf
  std::string base_frame = "base_link";
  Pose T_map_base_initial;
  std::filesystem::path last_pose;  ///< file in which the base's pose is kept for the next start
  MapMode mode = MapMode::kMaintenance;
  JournalParameters journal;
  double save_period = 3600;  ///< [s] between versions that are kept of the map
};

/// What became of the clouds that came.
struct ServerCounts {
  std::size_t used = 0;
  std::size_t stale = 0;             ///< a newer one was there before their turn
  std::size_t not_later = 0;         ///< by their stamps, than the one before
  std::size_t damaged = 0;           ///< no cloud of points
  std::size_t without_odometry = 0;  ///< nothing told the odometry at their time
  std::size_t foreign = 0;           ///< of a second publisher on the topic
  std::size_t believed = 0;
  std::size_t written = 0;  ///< into the map
};

/// The map keeper as a node of ROS 2: takes clouds, transforms and odometry, tells where the robot is, and
/// keeps a map file true. See MapTopics for what it sends. Needs no ROS: it speaks DDS.
///
/// Commands are std_msgs/String on ~/command, each answered on ~/reply: `save`, `pause` and `resume` (whether
/// the map is maintained), `relocalize`, `reset VERSION`. A pose on /initialpose is taken for the base's.
///
/// One thread calls all functions; the disk is written in another, so that no scan waits for it.
class MapServer {
 public:
  /// `store` must outlive the server. Throws DdsError when the network cannot be used.
  MapServer(MapStore& store, Octree map, const Parameters& parameters, const MapCause& cause,
            const ServerOptions& options);
  ~MapServer();

  /// Waits up to `seconds` for messages and deals with what came. Returns what was made of a cloud, if one
  /// was used. Throws DdsError.
  std::optional<ScanResult> step(double seconds);

  /// Makes the map that the robot left the last version; with `is_left_to_journal`, where there is a journal,
  /// leaves that to who opens it next. Throws FileError.
  void finish(bool is_left_to_journal);
  Octree map() const;

  /// Does what one on ~/command would; `reply` is called once, in step(), when it is done or refused.
  void command(const std::string& text, std::function<void(const std::string& reply)> reply);

  const ServerCounts& counts() const;
  Diagnosis diagnosis() const;
  const Pose& base_pose() const;  ///< T_map_base, where the base was last believed to be
  const std::vector<Eigen::Vector3d>& p_sensor_of_last() const;  ///< [m] points of the last cloud used

 private:
  class Node;

  std::unique_ptr<Node> node_;
};

}  // namespace evermap
