// SPDX-FileCopyrightText: 2026 the evermap authors
// SPDX-License-Identifier: BSD-3-Clause
#include <algorithm>
#include <utility>

#include <Eigen/Geometry>

#include <evermap/maintenance/scan_result.hpp>

namespace evermap {

ScanResult::PointCounts& ScanResult::PointCounts::operator+=(const PointCounts& other) {
  for (const auto count :
       {&PointCounts::total, &PointCounts::used, &PointCounts::not_finite, &PointCounts::at_origin,
        &PointCounts::near, &PointCounts::on_vehicle, &PointCounts::far, &PointCounts::out_of_grid}) {
    this->*count += other.*count;
  }
  return *this;
}

Eigen::Matrix<double, 6, 6> ScanResult::covariance_of(const Pose& T_sensor_frame) const {
  Eigen::Matrix<double, 6, 6> lever = Eigen::Matrix<double, 6, 6>::Identity();
  const Eigen::Vector3d arm = T_map_sensor.rotation * T_sensor_frame.translation;
  for (int axis = 0; axis < 3; ++axis) lever.col(3 + axis).head<3>() = Eigen::Vector3d::Unit(axis).cross(arm);
  return lever * covariance * lever.transpose();
}

void append(std::vector<ScanResult>& run, ScanResult result) {
  for (ScanResult& confirmed : result.confirmed) {
    const auto before = std::find_if(run.rbegin(), run.rend(),
                                     [&](const ScanResult& scan) { return scan.time == confirmed.time; });
    if (before != run.rend()) *before = std::move(confirmed);
  }
  result.confirmed.clear();
  run.push_back(std::move(result));
}

}  // namespace evermap
