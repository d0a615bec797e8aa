// SPDX-FileCopyrightText: 2026 the evermap authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cmath>
#include <numbers>

#include <Eigen/Core>

namespace evermap {

/// A spinning LiDAR, by default like an Ouster OS1-64: `channels` beams, evenly spread over the vertical
/// field of view, fire `columns` times per revolution.
struct LidarModel {
  int channels = 64;                             ///< beams, the topmost first
  int columns = 1024;                            ///< azimuths per revolution
  double elevation_max = std::numbers::pi / 8;   ///< [rad] of the topmost beam, 22.5 degrees
  double elevation_min = -std::numbers::pi / 8;  ///< [rad] of the lowest beam
  double rate = 10;                              ///< [Hz] revolutions
  double max_range = 200;                        ///< [m]
  double min_range = 0.5;                        ///< [m]
  double range_sigma = 0.02;                     ///< [m] standard deviation of a range

  int beams() const { return channels * columns; }

  /// Unit vector of a beam in the sensor frame; beams are numbered column by column, that is in the order of
  /// firing, counter-clockwise from x forward. REQUIRES: 0 <= beam < beams().
  Eigen::Vector3d direction(int beam) const {
    const double step = channels > 1 ? (elevation_max - elevation_min) / (channels - 1) : 0;
    const double elevation = elevation_max - step * (beam % channels);
    const int column = beam / channels;
    const double azimuth = 2 * std::numbers::pi * column / columns;
    return {std::cos(elevation) * std::cos(azimuth), std::cos(elevation) * std::sin(azimuth),
            std::sin(elevation)};
  }
};

}  // namespace evermap
