// SPDX-FileCopyrightText: 2026 the evermap authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <array>
#include <string>
#include <string_view>

#include <evermap/files/detail/record_layout.hpp>

namespace evermap {

/// The names, in any case, of a field that tells when its point was measured; the first of them that a file
/// has is taken.
inline constexpr std::array<std::string_view, 6> kTimeNames = {"t",          "time",        "timestamp",
                                                               "time_stamp", "offset_time", "time_offset"};

/// What a reader took the times of a file's points for. Times may be counted from any moment: a scan's are
/// counted from its earliest point.
struct PointTime {
  std::string field;  ///< as the file names it
  Scalar type;
  double seconds_per_tick;  ///< 1, 1e-3, 1e-6 or 1e-9
  double first;             ///< [s] of the earliest point, counted from whatever the recorder did
  double span;              ///< [s] from the first point to the last

  /// One line, such as "field 'timestamp' (float64) in nanoseconds, 0.0998 s from first to last".
  std::string describe() const;
};

/// "seconds" for 1, and so on.
std::string_view name_of_unit(double seconds_per_tick);

/// The unit [s] of times of this type of which the last is `span` ticks after the first. By itself a floating
/// time is in seconds (Velodyne, Hesai) and a whole number in nanoseconds (Ouster, Livox); another unit is
/// taken when only that makes a sweep of 0.02 to 0.5 s of the span.
double seconds_per_tick(Scalar type, double span);

}  // namespace evermap
