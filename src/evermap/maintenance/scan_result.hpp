// SPDX-FileCopyrightText: 2026 the evermap authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstddef>
#include <optional>
#include <string>
#include <vector>

#include <Eigen/Core>

#include <evermap/geometry/pose.hpp>
#include <evermap/localization/reject_reason.hpp>
#include <evermap/localization/tracking_state.hpp>

namespace evermap {

/// What MapMaintainer made of a scan.
struct ScanResult {
  /// What became of the scan's points.
  struct PointCounts {
    std::size_t total = 0;
    std::size_t used = 0;
    std::size_t not_finite = 0;
    std::size_t at_origin = 0;    ///< of zero range
    std::size_t near = 0;         ///< below min_range
    std::size_t on_vehicle = 0;   ///< in vehicle_box
    std::size_t far = 0;          ///< above max_range
    std::size_t out_of_grid = 0;  ///< beyond the range of keys

    PointCounts& operator+=(const PointCounts& other);
  };
  /// How long each stage took, by the clock on the wall.
  struct Times {
    double locate = 0;    ///< [s] deskewing, registration and gate
    double condense = 0;  ///< [s] points to ray bundles
    double trace = 0;     ///< [s] rays through the map
    double apply = 0;     ///< [s] the map changed
  };

  double time = 0;                                   ///< [s] when it ended, of a scan that was located
  Pose T_map_sensor;                                 ///< where the scan ended; see is_believed()
  TrackingState state = TrackingState::kTracking;    ///< after this scan
  RejectReason reject_reason = RejectReason::kNone;  ///< why the scan is not believed, or not written

  // Of a pose that was found:
  /// [m, rad] of (translation, rotation about the sensor) in the map's axes; zero where nothing tells.
  Eigen::Matrix<double, 6, 6> covariance = Eigen::Matrix<double, 6, 6>::Zero();
  std::string unobservable;    ///< the direction that nothing tells, in words; empty when there is none
  double inlier_fraction = 0;  ///< of the scan's bundles
  double residual = 0;         ///< mean squared Mahalanobis distance of these
  std::optional<double> contradicting_fraction;  ///< of the scan's rays; none when they were not traced

  bool is_written = false;          ///< whether the map has the scan
  std::size_t leaves_occupied = 0;  ///< leaves that became occupied
  std::size_t leaves_erased = 0;    ///< occupied leaves that went
  std::size_t rolled_back = 0;      ///< earlier scans whose changes were undone, since the robot is lost
  PointCounts points;
  Times times;

  /// Earlier scans that are believed since this one: those of a start, once the motion is known. In the order
  /// of their times; they take the places of the results that were given for these scans before.
  std::vector<ScanResult> confirmed;

  /// Nothing else is to be used as the robot's pose.
  bool is_believed() const {
    return reject_reason == RejectReason::kNone && state == TrackingState::kTracking;
  }

  /// `covariance` for a frame fixed to the sensor, whose place swings with the rotation about the sensor.
  Eigen::Matrix<double, 6, 6> covariance_of(const Pose& T_sensor_frame) const;
};

/// Adds the result of a run's next scan, and puts the results that it confirms in their places.
void append(std::vector<ScanResult>& run, ScanResult result);

}  // namespace evermap
