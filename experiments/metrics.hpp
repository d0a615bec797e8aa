// SPDX-FileCopyrightText: 2026 the evermap authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <Eigen/Geometry>

#include "experiments/dataset.hpp"
#include "report.hpp"
#include <evermap/evaluation/mapper.hpp>

namespace evermap {

/// `map` is the surface of a mapper [m], one point for each leaf.

/// COV and ACC at 0.1, 0.2 and 0.5 m, l/2 and l, the two mean distances and AHD [m]. The observed truth is
/// what a map has to cover; a point of the map is right where any true surface is, observed or not.
Json measure_surface(const Points& map, const Truth& truth, const Eigen::AlignedBox2d& area, double leaf);

/// The same on the whole truth: COV at 0.2 m and AHD.
Json measure_uncropped(const Points& map, const Truth& truth, const Eigen::AlignedBox2d& area);

/// SA, DA, AA and HA.
Json measure_changes(const Mapper& mapper, const Changes& changes, double position_sigma);

/// What a cell of a picture shows.
enum class Cell : char { kNothing = '.', kKept = 'k', kHole = 'h', kGhost = 'g' };
constexpr double kCellEdge = 0.3;  ///< [m]

/// The map from above, one character for each Cell, rows from north to south. Observed surface of which the
/// map has less than half is a hole; surface of the map where there is none, farther than a leaf, is a ghost.
Json seen_from_above(const Points& map, const Truth& truth, const Eigen::AlignedBox2d& view, double leaf);

}  // namespace evermap
