// SPDX-FileCopyrightText: 2026 the evermap authors
// SPDX-License-Identifier: BSD-3-Clause
#include "experiments/pcl_localizer.hpp"

#include <stdexcept>
#include <utility>

#include <evermap/scan/detail/deskew.hpp>

#ifdef EVERMAP_HAS_PCL
#include <pcl/console/print.h>
#include <pcl/registration/gicp.h>
#include <pcl/registration/ndt.h>

#include "experiments/pcl_cloud.hpp"
#endif

namespace evermap {

#ifdef EVERMAP_HAS_PCL
class PclLocalizer::Aligner {
 public:
  Aligner(std::string_view method, const std::vector<Eigen::Vector3d>& cloud_map) {
    constexpr double kMapPoints = 0.1;  // [m]
    pcl::console::setVerbosityLevel(pcl::console::L_ALWAYS);
    if (method == "PCL NDT") {
      auto ndt = std::make_unique<pcl::NormalDistributionsTransform<pcl::PointXYZ, pcl::PointXYZ>>();
      ndt->setResolution(1.0F);             // PCL's default: its cells need many points each
      ndt->setTransformationEpsilon(1e-6);  // of the squared step; the default stops at the first one
      ndt->setMaximumIterations(50);
      registration_ = std::move(ndt);
    } else {
      auto gicp = std::make_unique<pcl::GeneralizedIterativeClosestPoint<pcl::PointXYZ, pcl::PointXYZ>>();
      gicp->setMaxCorrespondenceDistance(1.0);
      gicp->setTransformationEpsilon(1e-5);
      gicp->setRotationEpsilon(1e-5);
      registration_ = std::move(gicp);
    }
    registration_->setInputTarget(pcl_cloud_of(cloud_map, kMapPoints));
  }

  std::optional<Pose> align(const Scan& scan, const Pose& guess) {
    constexpr double kScanPoints = 0.2;  // [m]
    const Eigen::Matrix4d end = pcl_align(*registration_, pcl_cloud_of(scan.p_sensor, kScanPoints), guess);
    if (!registration_->hasConverged() || !end.allFinite()) return std::nullopt;
    return Pose{nearest_rotation(end.topLeftCorner<3, 3>()), end.topRightCorner<3, 1>()};
  }

 private:
  std::unique_ptr<pcl::Registration<pcl::PointXYZ, pcl::PointXYZ>> registration_;
};

bool PclLocalizer::is_available() { return true; }
#else
class PclLocalizer::Aligner {
 public:
  Aligner(std::string_view /*method*/, const std::vector<Eigen::Vector3d>& /*cloud_map*/) {
    throw std::logic_error("built without PCL");
  }
  std::optional<Pose> align(const Scan& /*scan*/, const Pose& /*guess*/) { return std::nullopt; }
};

bool PclLocalizer::is_available() { return false; }
#endif

PclLocalizer::PclLocalizer(std::string_view method, const std::vector<Eigen::Vector3d>& cloud_map,
                           const Pose& T_map_sensor_initial, double scan_period)
    : aligner_(std::make_unique<Aligner>(method, cloud_map)),
      scan_period_(scan_period),
      T_map_sensor_(T_map_sensor_initial) {}
PclLocalizer::~PclLocalizer() = default;
PclLocalizer::PclLocalizer(PclLocalizer&&) noexcept = default;
PclLocalizer& PclLocalizer::operator=(PclLocalizer&&) noexcept = default;

std::optional<Pose> PclLocalizer::locate(const Scan& raw, const std::optional<Pose>& T_odom_sensor) {
  Twist velocity = velocity_;
  if (T_odom_before_ && T_odom_sensor)
    velocity = log(T_odom_before_->inverse() * *T_odom_sensor) / scan_period_;
  T_odom_before_ = T_odom_sensor;
  const Pose moved = is_first_ ? Pose{} : exp(scan_period_ * velocity);
  auto found =
      aligner_->align(deskew(raw, ScanMotion::steady(velocity), scan_period_), T_map_sensor_ * moved);
  const Pose T_map_before = std::exchange(T_map_sensor_, found.value_or(T_map_sensor_ * moved));
  if (!is_first_) velocity_ = log(T_map_before.inverse() * T_map_sensor_) / scan_period_;
  is_first_ = false;
  return found;
}

}  // namespace evermap
