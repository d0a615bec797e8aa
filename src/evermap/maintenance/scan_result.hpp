// SPDX-FileCopyrightText: 2026 the evermap authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstddef>

#include <evermap/localization/localizer.hpp>
#include <evermap/update/map_updater.hpp>

namespace evermap {

/// What became of a scan's points.
struct PointCounts {
  std::size_t total = 0;
  std::size_t used = 0;
  std::size_t not_finite = 0;
  std::size_t at_origin = 0;    ///< of zero range
  std::size_t near = 0;         ///< below min_range
  std::size_t far = 0;          ///< above max_range
  std::size_t out_of_grid = 0;  ///< beyond the range of keys

  PointCounts() = default;
  PointCounts(const Scan& scan, const BundleGrid& bundles);
  PointCounts& operator+=(const PointCounts& other);
};

/// How long each stage of a scan took, by the clock on the wall.
struct StageTimes {
  double locate = 0;    ///< [s] deskewing, registration and gate
  double condense = 0;  ///< [s] points to ray bundles
  double trace = 0;     ///< [s] rays through the map
  double apply = 0;     ///< [s] the map changed
};

/// What MapMaintainer made of a scan.
struct ScanResult {
  Pose T_map_sensor;                                 ///< where the scan ended; believed when is_believed()
  TrackingState state = TrackingState::kTracking;    ///< after this scan
  RejectReason reject_reason = RejectReason::kNone;  ///< why it is not believed, or not written
  Registration registration;            ///< fit and covariance; as it was made when the pose was given
  double contradicting_fraction = 0;    ///< of the scan's rays; 0 when they were not traced
  bool is_written = false;              ///< whether the map has it
  LeafChanges changes;
  PointCounts points;
  std::size_t rolled_back = 0;          ///< earlier scans whose changes this one undid: the robot is lost
  StageTimes times;

  bool is_believed() const {
    return reject_reason == RejectReason::kNone && state == TrackingState::kTracking;
  }
};

}  // namespace evermap
