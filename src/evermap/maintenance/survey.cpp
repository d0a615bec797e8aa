// SPDX-FileCopyrightText: 2026 the evermap authors
// SPDX-License-Identifier: BSD-3-Clause
#include <evermap/maintenance/detail/point_counts.hpp>
#include <evermap/maintenance/survey.hpp>
#include <evermap/update/detail/map_updater.hpp>

namespace evermap {

ScanResult::PointCounts add_survey(Octree& map, const Scan& cloud, const Pose& T_map_cloud,
                                   const Parameters& parameters) {
  return count_points(cloud, add_cloud(map, cloud, T_map_cloud, parameters.lidar, parameters.update));
}

}  // namespace evermap
