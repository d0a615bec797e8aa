// SPDX-FileCopyrightText: 2026 the evermap authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <functional>
#include <vector>

#include <evermap/evaluation/map_metrics.hpp>
#include <evermap/map/octree.hpp>
#include <evermap/scan/scan.hpp>
#include <evermap/simulation/change_truth.hpp>
#include <evermap/simulation/simulator.hpp>
#include <evermap/simulation/yard.hpp>

namespace evermap {

/// How well a map stands for the yard as it is now.
struct YardScore {
  double static_accuracy;   ///< SA: share of unchanged surface kept
  double dynamic_accuracy;  ///< DA: share of removed surface erased
  SurfaceComparison surface;
};

/// The demo's world at one leaf size: a map of the yard as it was, scans of a drive through the yard as it
/// is, and the truth, on what those scans could tell: unchanged and removed surface that at least 4 rays went
/// through and beyond, and surface that a ray hit.
class YardTrial {
 public:
  YardTrial(double leaf_edge, std::vector<Pose> T_map_sensor, const Yard& yard);

  const Octree& initial_map() const { return initial_map_; }
  const Points& initial_surface() const { return initial_surface_; }
  std::size_t size() const { return scans_.size(); }
  const Scan& scan(std::size_t i) const { return scans_[i]; }
  const Pose& pose(std::size_t i) const { return T_map_sensor_[i]; }

  YardScore score(const std::function<bool(const Eigen::Vector3d& p_map)>& claim, const Points& map) const;
  YardScore score(const Octree& octree) const;

 private:
  std::vector<Pose> T_map_sensor_;
  std::vector<Scan> scans_;
  Points initial_surface_;
  Octree initial_map_;
  Points unchanged_;
  Points removed_;
  Points observed_;
};

}  // namespace evermap
