// SPDX-FileCopyrightText: 2026 the evermap authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstddef>
#include <filesystem>
#include <functional>
#include <list>
#include <memory>
#include <mutex>
#include <optional>
#include <string>
#include <vector>

#include <evermap/map/octree.hpp>
#include <evermap/web/web_server.hpp>

namespace evermap {

class MapTiles;

/// What a browser shows of a map and its versions: the page itself, and what it asks for.
///
///   GET  /                                     the page
///   GET  /api/page                             what there is: frame, grid, versions
///   GET  /api/maps/MAP/blocks                  where there is surface: see TileBlock
///   GET  /api/maps/MAP/tiles/LEVEL/X/Y/Z       what to draw there: see TilePoint and MapTiles
///   GET  /api/maps/MAP/changes                 of two versions: what came and what went, in pieces
///   GET  /api/status                           where the robot is and how it is; of a file, when it changed
///   POST /api/command                          to the robot's map keeper
///
/// MAP is `now`, a version's number, or two of these, `3..now`: what the later one changed. All functions may
/// be called from several threads at once.
class MapPage {
 public:
  /// Of a file, at which `shown` is looked first: `now`, or `3..5`. Throws FileError.
  explicit MapPage(std::filesystem::path map, const std::string& shown = "now");
  /// Of a map that is being changed, as it is at first.
  MapPage(std::filesystem::path map, const Octree& begun);
  ~MapPage();
  MapPage(const MapPage&) = delete;
  MapPage& operator=(const MapPage&) = delete;

  void respond(const WebRequest& request, const WebRespond& respond);

  /// The changed map is this now. Returns what listeners are to be told, as JSON; empty when nothing that is
  /// drawn changed.
  std::string show(Octree map);
  /// For /api/status, as JSON.
  void set_status(std::string json);
  /// Who takes commands; without, there are none.
  using TakeCommand = std::function<void(const std::string& command, std::function<void(std::string)> reply)>;
  void set_commands(TakeCommand take);

 private:
  struct View;

  std::string describe();
  std::shared_ptr<View> view(const std::string& name);
  std::shared_ptr<View> load(const std::string& name) const;
  WebReply reply_to(const std::string& path);
  WebReply reply_of_map(const std::string& name, const std::vector<std::string>& words);

  std::filesystem::path map_;
  std::string shown_;
  std::shared_ptr<View> live_;  ///< none of a file

  std::mutex views_mutex_;                                          ///< held while a version is loaded
  std::list<std::pair<std::string, std::shared_ptr<View>>> views_;  ///< the last used first

  std::mutex robot_mutex_;  ///< of what a robot says and hears, which waits for nothing
  std::string status_;
  TakeCommand take_command_;
};

/// The page by itself, with a map in it: opens from disk, without a server. What went since `before` is
/// drawn, too. Of a large map coarser leaves are drawn, so that the file stays below 20 MB.
std::string page_with_map(const Octree& map, const std::optional<Octree>& before, const std::string& title);

}  // namespace evermap
