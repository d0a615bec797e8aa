// SPDX-FileCopyrightText: 2026 the evermap authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <evermap/geometry/pose.hpp>
#include <evermap/scan/scan.hpp>

namespace evermap {

/// Undoes the sensor's motion while it turned: every point as it would have been measured at the scan's end.
///
/// `T_begin_end` is the sensor's motion, taken to be steady, from the scan's begin to its end `duration` [s]
/// later. Times beyond the duration count as the end. A scan without times, or whose times are all the same,
/// comes back as it is.
Scan deskew(const Scan& scan, const Pose& T_begin_end, double duration);

}  // namespace evermap
