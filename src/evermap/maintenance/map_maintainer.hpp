// SPDX-FileCopyrightText: 2026 the evermap authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <memory>
#include <optional>

#include <evermap/maintenance/parameters.hpp>
#include <evermap/maintenance/scan_result.hpp>
#include <evermap/map/octree.hpp>
#include <evermap/scan/scan.hpp>

namespace evermap {

/// What scans do to the map.
enum class MapMode {
  kLocalization,  ///< nothing: the robot is localized in it
  kMapping,       ///< add surface and contradict nothing: how a map is built
  kMaintenance,   ///< bring it up to date
};

/// The closed loop: localizes a LiDAR in a map and keeps the map true with its scans, one by one.
///
///   scan --> deskew, register --gate--> condense --trace--> guard --> apply
///                    ^                                                   |
///                    +----------------- the better map <-----------------+
///
/// A pose that is not believed is not written, and what the last scans changed is undone, bit for bit, when
/// the robot turns out to be lost.
///
/// Threads: one at a time may call `process`; `map` may be called from any thread at any time. The work of a
/// scan is done in parallel in the caller's TBB arena, with the same bytes for any number of threads.
class MapMaintainer {
 public:
  /// `T_map_sensor_initial`: where the first scan is, within about 1 m and 10 degrees; in an empty map, the
  /// place it is given.
  explicit MapMaintainer(Octree map, const Parameters& parameters = {}, MapMode mode = MapMode::kMaintenance,
                         const Pose& T_map_sensor_initial = {});
  ~MapMaintainer();
  MapMaintainer(MapMaintainer&&) noexcept;
  MapMaintainer& operator=(MapMaintainer&&) noexcept;

  /// Takes a scan whose pose is to be found. `time` [s]: when it ended, later than the one before.
  /// `T_odom_sensor`: the sensor's pose then, in a frame that may drift; given for each scan or for none.
  /// `R_inertial_sensor`: its rotation alone, as a gyroscope's rates add up; likewise, and of use where there
  /// is no odometry. A scan with a time for each point is deskewed to its end.
  ScanResult process(const Scan& scan, double time, const std::optional<Pose>& T_odom_sensor = std::nullopt,
                     const std::optional<Eigen::Matrix3d>& R_inertial_sensor = std::nullopt);

  /// Takes a scan whose pose is known and trusted. `T_map_sensor_begin`: the pose when the scan began; with
  /// it, a scan with a time for each point is deskewed to its end, without it, all is taken as of one time.
  ScanResult process(const Scan& scan, const Pose& T_map_sensor,
                     const std::optional<Pose>& T_map_sensor_begin = std::nullopt);

  /// The map as it is after the last scan. A snapshot: it shares with this map what later scans leave
  /// unchanged, so taking one costs little, and stays as it is. Thread safe; waits at most while a scan's
  /// changes are being applied.
  Octree map() const;

  TrackingState state() const;

  /// From the next scan on.
  void set_mode(MapMode mode);

 private:
  class Loop;

  std::unique_ptr<Loop> loop_;
};

}  // namespace evermap
