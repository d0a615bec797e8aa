// SPDX-FileCopyrightText: 2026 the evermap authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstddef>
#include <optional>
#include <string>
#include <vector>

#include <evermap/geometry/pose.hpp>
#include <evermap/map/octree.hpp>
#include <evermap/scan/lidar_parameters.hpp>
#include <evermap/scan/scan.hpp>

namespace evermap {

/// Looks whether scans lie on a map where their poses put them, and where they do not, which of the mistakes
/// that people make with poses explains it: each is tried on the scans. Scans that make a map are to lie on
/// each other: for these, every mistake has a map of its own.
class PoseCheck {
 public:
  /// `map` as it was before the scans, empty for scans that make one; `poses` of all scans, as given, as far
  /// as they are known.
  PoseCheck(const Octree& map, const LidarParameters& lidar, std::vector<Pose> poses);

  /// The pose of a scan, which may be known only now.
  void note(std::size_t scan, const Pose& T_map_sensor);
  /// Whether the check wants to see this scan; ask once. Those that it does not want cost nothing.
  bool wants(std::size_t scan);
  /// REQUIRES: its pose is known. Costs as much as condensing the scan, and where it does not fit, once more
  /// for each mistake. `contradicting`: fraction of its rays that contradict the map.
  void add(std::size_t scan, const Scan& points, double contradicting);

  /// What is wrong with the poses and what to do, in words; empty while nothing is known against them.
  std::string verdict() const;

 private:
  double fit(const Octree& map, const Scan& points, const Pose& T_map_sensor) const;
  bool has_moved(std::size_t scan) const;

  const Octree& map_without(std::size_t mistake) const { return maps_[is_growing_ ? 1 + mistake : 0]; }

  std::vector<Octree> maps_;  ///< by the poses as given, and, when they grow, without each of the mistakes
  bool is_growing_;
  LidarParameters lidar_;
  std::vector<Pose> poses_;
  std::size_t asked_ = 0;            ///< scans that were offered
  std::size_t seen_ = 0;             ///< scans that were asked where they lie
  std::optional<std::size_t> last_;  ///< scan that was wanted
  double contradicting_ = 0;         ///< sum over these
  double fit_ = 0;                   ///< sum of how they fit as given
  std::vector<double> mended_fit_;   ///< and without each of the mistakes
};

}  // namespace evermap
