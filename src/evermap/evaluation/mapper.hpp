// SPDX-FileCopyrightText: 2026 the evermap authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstddef>
#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include <Eigen/Core>

#include <evermap/evaluation/map_metrics.hpp>
#include <evermap/geometry/pose.hpp>
#include <evermap/maintenance/scan_result.hpp>
#include <evermap/map/octree.hpp>
#include <evermap/scan/detail/ray_bundle.hpp>
#include <evermap/scan/scan.hpp>

namespace evermap {

/// A way to keep a map, as the experiments see it: start from a survey, take aligned scans, be asked what is
/// there. All mappers are given the same points: those whose range is within LidarParameters.
/// Not thread safe.
class Mapper {
 public:
  virtual ~Mapper() = default;

  const std::string& name() const { return name_; }
  virtual std::string version() const = 0;  ///< of the library behind it

  /// Makes the map of a survey [m, map frame], as sure as the map can be. `T_map_sensor_initial`: where the
  /// first scan is, for who localizes. REQUIRES: the map is empty.
  virtual void start(const Points& survey_map, const Pose& T_map_sensor_initial = {}) = 0;

  /// The integration of one aligned scan, ready to run. Conversion to the mapper's own types is done here,
  /// so that who times the returned call times the map alone.
  /// REQUIRES: it is run at most once, in the order of the scans, while the mapper and `scan` still are.
  virtual std::function<void()> prepare(const Scan& scan, const Pose& T_map_sensor) = 0;
  void update(const Scan& scan, const Pose& T_map_sensor) { prepare(scan, T_map_sensor)(); }

  /// A new run begins in the map as it is, its first scan there: what belongs to a run is forgotten.
  virtual void resume(const Pose& /*T_map_sensor_initial*/) {}

  /// Takes a scan whose pose is to be found, as MapMaintainer::process does; none where the mapper has no
  /// localization of its own.
  virtual std::optional<ScanResult> process(const Scan& /*scan*/, double /*time*/,
                                            const std::optional<Pose>& /*T_odom_sensor*/) {
    return std::nullopt;
  }

  /// Whether the map shows surface at a point [m, map frame] that is known to `position_sigma` [m]. A map of
  /// Gaussians: the point lies in its leaf's ellipsoid, widened by position_sigma; a grid: its voxel is
  /// occupied.
  virtual bool claims(const Eigen::Vector3d& p_map, double position_sigma) const = 0;
  /// Whether the map knows of anything there, were it still to be confirmed.
  virtual bool notices(const Eigen::Vector3d& p_map, double position_sigma) const {
    return claims(p_map, position_sigma);
  }
  /// One point [m, map frame] per occupied leaf: the Gaussian's mean, or the voxel's centre.
  virtual Points surface() const = 0;
  virtual std::size_t memory_bytes() const = 0;  ///< by its own account
  /// The map itself where it is one of Gaussians, else nullptr.
  virtual const Octree* gaussian_map() const { return nullptr; }

 protected:
  explicit Mapper(std::string name) : name_(std::move(name)) {}
  Mapper(const Mapper&) = default;
  Mapper& operator=(const Mapper&) = default;

 private:
  std::string name_;
};

/// The mappers by name, in the order of tables:
/// - "static map": what the survey showed; scans change nothing.
/// - "OctoMap": an OctoMapBaseline that is fed all points.
/// - "OctoMap, voxel means": an OctoMapBaseline that is fed one point per voxel and scan, the points' mean.
/// - "UFOMap": an UfoMapBaseline that is fed all points.
/// - "Bonxai": a BonxaiBaseline that is fed all points.
/// - "evermap paper": UpdateParameters::paper().
/// - "evermap default": UpdateParameters{}.
const std::vector<std::string>& mapper_names();

/// An empty map with leaves of `edge` [m]; nullptr when evermap was built without the library behind it ("not
/// installed"). Throws std::invalid_argument, which lists the names, when there is none of this name.
std::unique_ptr<Mapper> make_mapper(std::string_view name, double edge, const LidarParameters& lidar = {});

}  // namespace evermap
