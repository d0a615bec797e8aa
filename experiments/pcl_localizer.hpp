// SPDX-FileCopyrightText: 2026 the evermap authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <memory>
#include <optional>
#include <string_view>
#include <vector>

#include <evermap/geometry/pose.hpp>
#include <evermap/scan/scan.hpp>

namespace evermap {

/// Localization as it is often done: each scan is aligned by PCL to the cloud of the map, from where
/// odometry, or the velocity before, leads. What converges is believed.
class PclLocalizer {
 public:
  static constexpr std::string_view kMethods[] = {"PCL NDT", "PCL GICP"};
  /// Whether evermap was built with PCL.
  static bool is_available();

  /// `method`: one of kMethods. `cloud_map` [m]: the map. REQUIRES: is_available().
  PclLocalizer(std::string_view method, const std::vector<Eigen::Vector3d>& cloud_map,
               const Pose& T_map_sensor_initial, double scan_period);
  ~PclLocalizer();
  PclLocalizer(PclLocalizer&&) noexcept;
  PclLocalizer& operator=(PclLocalizer&&) noexcept;

  /// Where the next scan ended, `T_odom_sensor` being the odometry there; none when it did not converge.
  std::optional<Pose> locate(const Scan& raw, const std::optional<Pose>& T_odom_sensor);

 private:
  class Aligner;

  std::unique_ptr<Aligner> aligner_;
  double scan_period_;  ///< [s]
  Pose T_map_sensor_;
  std::optional<Pose> T_odom_before_;
  Twist velocity_ = Twist::Zero();  ///< [m/s, rad/s]
  bool is_first_ = true;
};

}  // namespace evermap
