// SPDX-FileCopyrightText: 2026 the evermap authors
// SPDX-License-Identifier: BSD-3-Clause
#include <utility>

#include <evermap/evaluation/evermap_contender.hpp>
#include <evermap/evaluation/map_claims.hpp>
#include <evermap/update/map_updater.hpp>

namespace evermap {

EvermapContender::EvermapContender(std::string name, double edge, const Parameters& parameters)
    : Contender(std::move(name)),
      parameters_(parameters),
      octree_(VoxelGrid{.edge = edge}),
      viewpoint_(parameters.update.standstill) {}

std::string EvermapContender::version() const { return EVERMAP_VERSION; }

void EvermapContender::start(const Points& survey_map) {
  Scan survey;
  survey.p_sensor = survey_map;
  add_cloud(octree_, survey, Pose{}, parameters_.lidar, parameters_.update);
}

std::function<void()> EvermapContender::prepare(const Scan& scan, const Pose& T_map_sensor) {
  return [this, &scan, T_map_sensor] {
    evermap::update(octree_, condense(scan, T_map_sensor, octree_.grid(), parameters_.lidar), parameters_.update,
                    viewpoint_.view_weight(T_map_sensor));
  };
}

bool EvermapContender::claims(const Eigen::Vector3d& p_map, double position_sigma) const {
  return evermap::claims(octree_, p_map, position_sigma);
}

bool EvermapContender::notices(const Eigen::Vector3d& p_map, double position_sigma) const {
  return evermap::notices(octree_, p_map, position_sigma);
}

Points EvermapContender::surface() const { return surface_points(octree_); }
std::size_t EvermapContender::memory_bytes() const { return octree_.memory_bytes(); }

}  // namespace evermap
