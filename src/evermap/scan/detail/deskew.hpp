// SPDX-FileCopyrightText: 2026 the evermap authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <evermap/geometry/pose.hpp>
#include <evermap/scan/scan.hpp>

namespace evermap {

/// How a sensor moved while it took a scan: at one velocity until a moment, at another from there on.
struct ScanMotion {
  /// At one velocity [m/s, rad/s] all the time.
  static ScanMotion steady(const Twist& velocity) { return {velocity, velocity, 0}; }

  /// Where the sensor was when `fraction` of the scan was taken, seen from where it was at its end.
  Pose pose_at(double fraction, double duration) const;

  Twist before = Twist::Zero(), after = Twist::Zero();  ///< [m/s, rad/s] in the sensor's frame
  double bend = 0;                                      ///< fraction of the scan
};

/// Whether points were measured at different times, and say so.
bool has_times(const Scan& scan);

/// Undoes the sensor's motion while it turned: every point as it would have been measured at the scan's end,
/// `duration` [s] after its begin. Times beyond the duration count as the end. A scan without times, or whose
/// times are all the same, comes back as it is.
Scan deskew(const Scan& scan, const ScanMotion& motion, double duration);

/// The same for a scan that began at `T_end_begin`, seen from where it ended. REQUIRES: has_times(scan).
Scan deskew_between(const Scan& scan, const Pose& T_end_begin);

/// The fraction of a scan of `duration` [s] that was taken at `time_offset` [s], at most 1.
double fraction_at(float time_offset, double duration);

}  // namespace evermap
