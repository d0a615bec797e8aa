// SPDX-FileCopyrightText: 2026 the evermap authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstddef>
#include <optional>

#include <evermap/io/detail/point_time.hpp>

namespace evermap {

/// What a reader has made of a cloud's file, for whoever reports it.
struct CloudNotes {
  std::optional<PointTime> time;   ///< none when the points have no time
  std::size_t bin_fields = 0;      ///< float32 values a point in a .bin file, 0 in others
  bool has_viewpoint = false;      ///< the file says where the sensor was, by a PCD VIEWPOINT
  double voxel = 0;                ///< [m] edge of the voxels whose middles the points are, 0 in others
  double coordinate_step = 0;      ///< [m] between neighbouring float32 values at the farthest coordinate;
                                   ///< 0 when they are of another type
  double farthest_coordinate = 0;  ///< [m] the largest x, y or z, without its sign
};

}  // namespace evermap
