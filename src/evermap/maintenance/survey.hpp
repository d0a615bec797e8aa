// SPDX-FileCopyrightText: 2026 the evermap authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <evermap/maintenance/parameters.hpp>
#include <evermap/maintenance/scan_result.hpp>
#include <evermap/map/octree.hpp>
#include <evermap/scan/scan.hpp>

namespace evermap {

/// Merges a survey's cloud into the map, trusted as it is: every range, and every leaf as sure as can be.
ScanResult::PointCounts add_survey(Octree& map, const Scan& cloud, const Pose& T_map_cloud,
                                   const Parameters& parameters = {});

}  // namespace evermap
