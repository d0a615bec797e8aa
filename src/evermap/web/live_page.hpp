// SPDX-FileCopyrightText: 2026 the evermap authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <filesystem>
#include <future>
#include <span>
#include <string>
#include <utility>
#include <vector>

#include <evermap/geometry/pose.hpp>
#include <evermap/map/octree.hpp>
#include <evermap/web/map_page.hpp>
#include <evermap/web/web_server.hpp>

namespace evermap {

/// How a robot is.
struct RobotStatus {
  double time = 0;  ///< [s] of the last scan
  std::string state;
  int level = 0;        ///< 0: all is well, 1: a warning, 2: an error
  std::string message;  ///< why
  bool is_believed = false;
  Pose T_map_base;  ///< of use when believed
  std::vector<std::pair<std::string, std::string>> values;
};

/// The page of a map that a robot keeps, as it changes. One thread calls all functions but what `commands` is
/// given, which is called in threads of the server's.
class LivePage {
 public:
  /// `begun`: what changes are told from. Throws WebError.
  LivePage(const std::filesystem::path& map, const Octree& begun, const WebOptions& options,
           MapPage::TakeCommand commands);
  ~LivePage();
  LivePage(const LivePage&) = delete;
  LivePage& operator=(const LivePage&) = delete;

  const WebServer& server() const { return server_; }
  bool is_watched() const { return server_.listeners() > 0; }

  void tell(const RobotStatus& status);
  /// Points [m] of a scan that was taken at T_map_sensor; of many, some are shown.
  void show_scan(std::span<const Eigen::Vector3d> p_sensor, const Pose& T_map_sensor);
  /// Whether the map before is drawn, and the next may come.
  bool is_ready();
  /// The map as it is now; compared with the one before in another thread. REQUIRES: is_ready().
  void show(Octree map);

 private:
  MapPage page_;
  WebServer server_;
  std::future<void> showing_;
};

}  // namespace evermap
