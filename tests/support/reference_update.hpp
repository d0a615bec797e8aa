// SPDX-FileCopyrightText: 2026 the evermap authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <map>
#include <set>

#include <Eigen/Core>

#include <evermap/geometry/pose.hpp>
#include <evermap/geometry/voxel_key.hpp>
#include <evermap/maintenance/parameters.hpp>
#include <evermap/scan/scan.hpp>

namespace evermap::test {

/// A leaf of the reference map; what the map stores as float is rounded to float here too.
struct ReferenceLeaf {
  Eigen::Vector3d mean;        ///< [m] map frame
  Eigen::Matrix3d covariance;  ///< [m^2]
  double count;
  double log_odds;
};

/// The whole update once more: plain, slow, one thread, written from the method's formulas and the
/// parameters' documentation and sharing none of the library's arithmetic. Of the library it uses the grid
/// and its keys alone.
class ReferenceUpdate {
 public:
  explicit ReferenceUpdate(const VoxelGrid& grid) : grid_(grid) {}

  void add(const Scan& scan, const Pose& T_map_sensor, const Parameters& parameters);
  void update(const Scan& scan, const Pose& T_map_sensor, const Parameters& parameters);

  std::map<VoxelKey, ReferenceLeaf> leaves;
  /// Leaves whose fate in the last scan hung on a direction that nothing determines (an eigenvector of a
  /// repeated eigenvalue): any choice is right, and another implementation may choose another.
  std::set<VoxelKey> ambiguous;

 private:
  VoxelGrid grid_;
};

}  // namespace evermap::test
