// SPDX-FileCopyrightText: 2026 the evermap authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <string>
#include <utility>
#include <vector>

#include <evermap/maintenance/scan_result.hpp>
#include <evermap/map/detail/surface_changes.hpp>
#include <evermap/map/octree.hpp>
#include <evermap/ros/detail/dds.hpp>
#include <evermap/ros/diagnosis.hpp>

namespace evermap {

/// What evermap tells the robot, on topics of ROS 2 by its conventions. `~` is the node's name.
///
///   /tf              map -> odom (or -> base, where nothing tells odometry)
///   ~/pose           geometry_msgs/PoseWithCovarianceStamped of the base
///   ~/odometry       nav_msgs/Odometry, map -> base
///   ~/map            sensor_msgs/PointCloud2: the occupied leaves, latched
///   ~/map_updates    the same of the tiles that changed; they replace what was there
///   ~/changes        visualization_msgs/MarkerArray: boxes of what came and went
///   /diagnostics     diagnostic_msgs/DiagnosticArray
///   ~/reply          std_msgs/String: what became of a command
class MapTopics {
 public:
  MapTopics(DdsNode& node, const std::string& name, std::string map_frame);

  void send_transform(double time, const std::string& child, const Pose& T_map_child);
  /// `base`: a frame on the robot, at T_sensor_base.
  void send_pose(const ScanResult& scan, const std::string& base, const Pose& T_sensor_base);
  /// The whole map.
  void send_map(double time, const Octree& map);
  /// Tiles of both maps, each a block, in which they differ.
  void send_updates(double time, const Octree& before, const Octree& after);
  void send_changes(double time, const std::vector<SurfaceChange>& changes);
  void send_diagnosis(double time, const Diagnosis& diagnosis);
  void send_reply(const std::string& text);

  std::size_t map_readers() const { return map_.readers(); }
  bool has_update_readers() const { return updates_.readers() > 0; }

 private:
  std::string name_;
  std::string map_frame_;
  DdsWriter transforms_;
  DdsWriter pose_;
  DdsWriter odometry_;
  DdsWriter map_;
  DdsWriter updates_;
  DdsWriter changes_;
  DdsWriter diagnostics_;
  DdsWriter reply_;
  int change_id_ = 0;
  const std::string empty_;
};

}  // namespace evermap
