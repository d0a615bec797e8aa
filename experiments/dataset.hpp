// SPDX-FileCopyrightText: 2026 the evermap authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstddef>
#include <functional>
#include <string>
#include <vector>

#include <Eigen/Core>
#include <Eigen/Geometry>

#include <evermap/evaluation/map_metrics.hpp>
#include <evermap/evaluation/ray_coverage.hpp>
#include <evermap/scan/detail/ray_bundle.hpp>
#include <evermap/scan/scan.hpp>

namespace evermap {

struct AlignedScan {
  Scan scan;
  Pose T_map_sensor;
};

/// The true surface at one moment, without what moves.
struct Truth {
  Points surface;   ///< [m] samples of all of it
  Points observed;  ///< those that the run observed
  /// Distance [m] of each map point to the nearest true surface. Thread safe.
  std::function<std::vector<double>(const Points&)> distances;
};

/// What the survey showed and what became of it by the end of the run, on points [m] that the run's rays
/// could contradict.
struct Changes {
  Points unchanged;
  Points removed;
};

/// Something that passes while the map is kept.
struct DynamicObject {
  std::string name;
  std::vector<Points> p_map;  ///< [m] the points on it, by scan
};

/// A world with a survey, a run of aligned scans and the truth: what mappers are compared on.
/// Const members are thread safe.
class Dataset {
 public:
  virtual ~Dataset() = default;
  Dataset(const Dataset&) = delete;
  Dataset& operator=(const Dataset&) = delete;

  const std::vector<AlignedScan>& scans() const { return scans_; }
  const std::vector<DynamicObject>& dynamic_objects() const { return dynamic_objects_; }
  /// The place of a scan in the data that it comes from, where scans were left out.
  virtual std::size_t number(std::size_t scan) const = 0;
  /// When a scan was taken [s].
  double time(std::size_t scan) const { return 0.1 * static_cast<double>(number(scan)); }

  virtual Points survey() const = 0;
  virtual Truth truth(std::size_t scan) const = 0;
  virtual Changes changes(double leaf) const = 0;
  /// The rays of all scans.
  std::vector<ScanRays> rays() const;

  LidarParameters lidar{};
  double position_sigma = 0.02;  ///< [m] how well the place of a true point is known
  Eigen::AlignedBox2d area;      ///< [m] that is measured, seen from above
  Eigen::AlignedBox2d view;      ///< [m] that pictures show

 protected:
  Dataset() = default;

  std::vector<AlignedScan> scans_;
  std::vector<DynamicObject> dynamic_objects_;
};

/// The first point of each voxel of that size [m].
Points thinned(const Points& points, double edge);

/// Those of the points that lie in the area, seen from above.
Points within(const Eigen::AlignedBox2d& area, const Points& points);

}  // namespace evermap
