// SPDX-FileCopyrightText: 2026 the evermap authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <optional>
#include <string>

#include <evermap/evaluation/mapper.hpp>
#include <evermap/maintenance/map_maintainer.hpp>

namespace evermap {

/// evermap under any parameters, for ablations and for what needs the map itself.
class EvermapMapper final : public Mapper {
 public:
  EvermapMapper(std::string name, double edge, const Parameters& parameters,
                MapMode mode = MapMode::kMaintenance);

  std::string version() const override;
  void start(const Points& survey_map, const Pose& T_map_sensor_initial = {}) override;
  std::function<void()> prepare(const Scan& scan, const Pose& T_map_sensor) override;
  void resume(const Pose& T_map_sensor_initial) override;
  std::optional<ScanResult> process(const Scan& scan, double time,
                                    const std::optional<Pose>& T_odom_sensor) override;
  bool claims(const Eigen::Vector3d& p_map, double position_sigma) const override;
  bool notices(const Eigen::Vector3d& p_map, double position_sigma) const override;
  Points surface() const override;
  std::size_t memory_bytes() const override;
  const Octree* gaussian_map() const override { return &map(); }

 private:
  const Octree& map() const;

  Parameters parameters_;
  MapMode mode_;
  double edge_;  ///< [m]
  MapMaintainer maintainer_;
  mutable std::optional<Octree> map_;  ///< the maintainer's, while no scan has come since it was asked for
};

}  // namespace evermap
