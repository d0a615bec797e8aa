// SPDX-FileCopyrightText: 2026 the evermap authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <string>

#include <evermap/evaluation/contender.hpp>
#include <evermap/map/octree.hpp>
#include <evermap/maintenance/parameters.hpp>
#include <evermap/update/viewpoint.hpp>

namespace evermap {

/// evermap under any parameters, for ablations and for what needs the map itself.
class EvermapContender final : public Contender {
 public:
  EvermapContender(std::string name, double edge, const Parameters& parameters);

  std::string version() const override;
  void start(const Points& survey_map) override;
  std::function<void()> prepare(const Scan& scan, const Pose& T_map_sensor) override;
  bool claims(const Eigen::Vector3d& p_map, double position_sigma) const override;
  bool notices(const Eigen::Vector3d& p_map, double position_sigma) const override;
  Points surface() const override;
  std::size_t memory_bytes() const override;

  const Octree* gaussian_map() const override { return &octree_; }

 private:
  Parameters parameters_;
  Octree octree_;
  Viewpoint viewpoint_;
};

}  // namespace evermap
