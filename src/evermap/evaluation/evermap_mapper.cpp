// SPDX-FileCopyrightText: 2026 the evermap authors
// SPDX-License-Identifier: BSD-3-Clause
#include <utility>

#include <evermap/evaluation/evermap_mapper.hpp>
#include <evermap/evaluation/map_claims.hpp>
#include <evermap/maintenance/survey.hpp>

namespace evermap {

EvermapMapper::EvermapMapper(std::string name, double edge, const Parameters& parameters, MapMode mode)
    : Mapper(std::move(name)),
      parameters_(parameters),
      mode_(mode),
      edge_(edge),
      maintainer_(Octree(VoxelGrid{.edge = edge}), parameters, mode) {}

std::string EvermapMapper::version() const { return EVERMAP_VERSION; }

void EvermapMapper::start(const Points& survey_map, const Pose& T_map_sensor_initial) {
  Scan survey;
  survey.p_sensor = survey_map;
  Octree map(VoxelGrid{.edge = edge_});
  add_survey(map, survey, Pose{}, parameters_);
  map_.reset();
  maintainer_ = MapMaintainer(std::move(map), parameters_, mode_, T_map_sensor_initial);
}

std::function<void()> EvermapMapper::prepare(const Scan& scan, const Pose& T_map_sensor) {
  return [this, &scan, T_map_sensor] {
    map_.reset();
    maintainer_.process(scan, T_map_sensor);
  };
}

void EvermapMapper::resume(const Pose& T_map_sensor_initial) {
  maintainer_ = MapMaintainer(maintainer_.map(), parameters_, mode_, T_map_sensor_initial);
}

std::optional<ScanResult> EvermapMapper::process(const Scan& scan, double time,
                                                 const std::optional<Pose>& T_odom_sensor) {
  map_.reset();
  return maintainer_.process(scan, time, T_odom_sensor);
}

bool EvermapMapper::claims(const Eigen::Vector3d& p_map, double position_sigma) const {
  return evermap::claims(map(), p_map, position_sigma);
}

bool EvermapMapper::notices(const Eigen::Vector3d& p_map, double position_sigma) const {
  return evermap::notices(map(), p_map, position_sigma);
}

Points EvermapMapper::surface() const { return surface_points(map()); }
std::size_t EvermapMapper::memory_bytes() const { return map().memory_bytes(); }

const Octree& EvermapMapper::map() const {
  if (!map_) map_ = maintainer_.map();
  return *map_;
}

}  // namespace evermap
