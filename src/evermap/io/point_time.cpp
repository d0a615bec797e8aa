// SPDX-FileCopyrightText: 2026 the evermap authors
// SPDX-License-Identifier: BSD-3-Clause
#include <algorithm>
#include <array>
#include <cstdio>

#include <evermap/io/detail/point_time.hpp>

namespace evermap {
namespace {

constexpr double kShortestSweep = 0.02;  // [s] 50 Hz
constexpr double kLongestSweep = 0.5;    // [s] 2 Hz

struct Unit {
  double seconds;
  std::string_view name;
};
constexpr std::array<Unit, 4> kUnits = {
    {{1, "seconds"}, {1e-3, "milliseconds"}, {1e-6, "microseconds"}, {1e-9, "nanoseconds"}}};

bool is_sweep(double seconds) { return seconds >= kShortestSweep && seconds <= kLongestSweep; }

}  // namespace

double seconds_per_tick(Scalar type, double span) {
  const double usual = is_floating(type) ? 1 : 1e-9;
  if (is_sweep(span * usual)) return usual;
  // Units are a factor of 1000 apart and sweeps one of 25: no two of them fit.
  const auto* fitting = std::find_if(kUnits.begin(), kUnits.end(),
                                     [&](const Unit& unit) { return is_sweep(span * unit.seconds); });
  return fitting == kUnits.end() ? usual : fitting->seconds;
}

std::string_view name_of_unit(double seconds_per_tick) {
  return std::find_if(kUnits.begin(), kUnits.end(),
                      [&](const Unit& known) { return known.seconds == seconds_per_tick; })
      ->name;
}

std::string PointTime::describe() const {
  std::array<char, 32> digits{};
  std::snprintf(digits.data(), digits.size(), "%.3g", span);
  return "field '" + field + "' (" + std::string(name_of(type)) + ") in " +
         std::string(name_of_unit(seconds_per_tick)) + ", " + digits.data() + " s from first to last";
}

}  // namespace evermap
