// SPDX-FileCopyrightText: 2026 the evermap authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstddef>
#include <string>
#include <vector>

#include <Eigen/Core>

#include <evermap/geometry/pose.hpp>
#include <evermap/scan/scan.hpp>
#include <evermap/simulation/ray_caster.hpp>
#include <evermap/simulation/scenario.hpp>
#include <evermap/simulation/scene.hpp>

namespace evermap {

/// A simulated scan and what each of its points is on.
struct LabelledScan {
  Scan scan;
  std::vector<int> object;  ///< id by point
};

/// A scenario as it is driven: scans, poses, survey and truth.
///
/// Scan i covers one revolution and is stamped with its END, `time(i)` = (i + 1) revolutions. With motion
/// distortion the sensor moves while it turns: a point is given in the sensor frame of the moment when its
/// column was measured, time(i) minus one revolution plus the point's time_offset, and
/// `T_map_sensor(that moment)` undoes it. Without, all is measured at the end and time_offset stays empty.
/// All else that moves stands still during a revolution, as it is at its end.
///
/// Thread safe; the same scenario gives the same scans, whatever was asked before.
class ScenarioDrive {
 public:
  /// Throws FileError when an object contains the sensor at some scan.
  explicit ScenarioDrive(Scenario scenario);

  const Scenario& scenario() const { return scenario_; }
  std::size_t size() const { return static_cast<std::size_t>(scenario_.scans); }
  double time(std::size_t index) const;  ///< [s] of the scan's end
  // NOLINTBEGIN(readability-identifier-naming): poses are named by their frames.
  /// The pose of a scan. REQUIRES: index < size(), of all that follows too.
  Pose T_map_sensor(std::size_t index) const { return T_map_sensor_at(time(index)); }
  Pose T_map_sensor_at(double time) const;
  // NOLINTEND(readability-identifier-naming)

  LabelledScan scan(std::size_t index) const;
  /// The points of this scan in the map frame [m], motion distortion undone.
  std::vector<Eigen::Vector3d> in_map(std::size_t index, const Scan& scan) const;

  /// The surface when the survey was made, as points `spacing` [m] apart: what the first map is made of.
  /// Throws FileError when these, or those of truth(), would be more than 30 million.
  std::vector<Eigen::Vector3d> survey(double spacing) const;
  /// The whole true surface at a scan, with ids of objects.
  std::vector<SurfaceSample> truth(std::size_t index, double spacing) const;

  /// The world in the survey and at a scan, for change_truth; each box of a body is a solid of its own.
  Scene survey_scene() const;
  Scene scene(std::size_t index) const;
  /// The world at a scan without what moves: what a map should show.
  Scene settled_scene(std::size_t index) const;
  /// The object that a solid of these scenes belongs to.
  static int object_of(int solid);

  /// REQUIRES: `object` is an id of this drive, in these too.
  ObjectClass class_of(int object) const;
  std::string name_of(int object) const;

 private:
  void check_sensor_is_free() const;
  std::vector<SurfaceSample> samples_of(const Scene& scene, double spacing) const;
  /// The sensor's pose that belongs to what it measured `offset` [s] after the begin of a scan.
  Pose pose_in_scan(std::size_t index, double offset) const;
  double reflectivity_of(int object) const;
  Scene changing_scene(double time) const;

  Scenario scenario_;
  Scene unchanging_;
  RayCaster unchanging_rays_;
};

}  // namespace evermap
