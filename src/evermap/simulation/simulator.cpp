// SPDX-FileCopyrightText: 2026 the evermap authors
// SPDX-License-Identifier: BSD-3-Clause
#include <evermap/simulation/noise.hpp>
#include <evermap/simulation/simulator.hpp>

namespace evermap {

Simulator::Simulator(const Scene& scene) : ray_caster_(scene) {}

Scan Simulator::scan(const Pose& T_map_sensor, const LidarModel& lidar, std::uint64_t seed) const {
  Scan scan;
  for (const BeamHit& hit : hits(T_map_sensor, lidar)) {
    const double noise = lidar.range_sigma * standard_normal(seed, static_cast<std::uint64_t>(hit.beam));
    scan.p_sensor.emplace_back((hit.range + noise) * lidar.direction(hit.beam));
  }
  return scan;
}

std::vector<BeamHit> Simulator::hits(const Pose& T_map_sensor, const LidarModel& lidar) const {
  std::vector<BeamHit> hits;
  for (int beam = 0; beam < lidar.beams(); ++beam) {
    const Eigen::Vector3d direction = T_map_sensor.rotation * lidar.direction(beam);
    const auto hit = ray_caster_.first_hit(T_map_sensor.translation, direction);
    if (!hit || hit->range < lidar.min_range || hit->range > lidar.max_range) continue;
    hits.push_back({beam, hit->object, hit->range, T_map_sensor.translation + hit->range * direction});
  }
  return hits;
}

std::optional<double> Simulator::range(const Eigen::Vector3d& origin,
                                       const Eigen::Vector3d& direction) const {
  const auto hit = ray_caster_.first_hit(origin, direction.normalized());
  return hit ? std::optional(hit->range) : std::nullopt;
}

}  // namespace evermap
