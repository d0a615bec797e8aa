// SPDX-FileCopyrightText: 2026 the evermap authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cmath>
#include <optional>
#include <string>

namespace evermap {

/// The frame that a map's coordinates are in: its name, as in /tf, and where on earth its origin is, if that
/// is known (x east, y north).
struct MapFrame {
  /// A place in WGS 84.
  struct GeoPoint {
    double latitude;   ///< [degrees] north
    double longitude;  ///< [degrees] east
    double altitude;   ///< [m] above the ellipsoid

    bool is_sound() const {
      return std::abs(latitude) <= 90 && std::abs(longitude) <= 180 && std::abs(altitude) <= 1e5;
    }
    friend bool operator==(const GeoPoint&, const GeoPoint&) = default;
  };

  std::string name = "map";
  std::optional<GeoPoint> origin;

  friend bool operator==(const MapFrame&, const MapFrame&) = default;
};

}  // namespace evermap
