// SPDX-FileCopyrightText: 2026 the evermap authors
// SPDX-License-Identifier: BSD-3-Clause
#include <cmath>

#include <evermap/evaluation/labelled_drive.hpp>
#include <evermap/evaluation/map_metrics.hpp>

namespace evermap {
namespace {

constexpr double kVehicleRadius = 2.5;  // [m]
constexpr double kGrowth = 0.1;         // [m] label noise
constexpr double kWheels = 0.15;        // [m]

/// The point's height above the bottom of the grown box [m]; NaN outside.
double height_in_box(const LabelledBox& box, const Eigen::Vector3d& p_sensor) {
  const Eigen::Vector3d from_center = p_sensor - box.center_sensor;
  const double c = std::cos(box.yaw);
  const double s = std::sin(box.yaw);
  const Eigen::Vector3d p_box(c * from_center.x() + s * from_center.y(),
                              c * from_center.y() - s * from_center.x(), from_center.z());
  const Eigen::Vector3d half = box.size / 2 + Eigen::Vector3d::Constant(kGrowth);
  if ((p_box.cwiseAbs() - half).maxCoeff() > 0) return std::nan("");
  return p_box.z() + box.size.z() / 2;
}

PointClass classify(const Eigen::Vector3d& p_sensor, const std::vector<LabelledBox>& boxes) {
  if (p_sensor.norm() < kVehicleRadius) return PointClass::kExcluded;
  PointClass result = PointClass::kStatic;
  for (const LabelledBox& box : boxes) {
    const double height = height_in_box(box, p_sensor);
    if (std::isnan(height)) continue;
    if (box.motion == LabelledBox::Motion::kUncertain) return PointClass::kExcluded;
    if (box.motion == LabelledBox::Motion::kMoving) {
      return height < kWheels ? PointClass::kExcluded : PointClass::kMoving;
    }
    result = PointClass::kParked;
  }
  return result;
}

}  // namespace

std::vector<PointClass> classify(const Scan& scan, const std::vector<LabelledBox>& boxes) {
  std::vector<PointClass> classes;
  classes.reserve(scan.p_sensor.size());
  for (const Eigen::Vector3d& p : scan.p_sensor) classes.push_back(classify(p, boxes));
  return classes;
}

void add_to_score(DriveScore& score, const Scan& scan, const Pose& T_map_sensor,
                  const std::vector<LabelledBox>& boxes, bool is_last, const Claim& claim) {
  constexpr double kLabelledSlope = 0.839;  // tan(40 degrees): the labels reach as far as the camera saw
  const std::vector<PointClass> classes = classify(scan, boxes);
  for (std::size_t i = 0; i < classes.size(); ++i) {
    const Eigen::Vector3d& p_sensor = scan.p_sensor[i];
    const PointClass kind = classes[i];
    if (kind == PointClass::kExcluded || (kind == PointClass::kMoving && is_last)) continue;
    const bool claimed = claim(T_map_sensor * p_sensor);
    const auto count = [claimed](DriveScore::Fraction& fraction) {
      ++fraction.points;
      fraction.claimed += claimed ? 1 : 0;
    };
    if (kind == PointClass::kMoving) count(score.moving);
    if (kind == PointClass::kParked) count(score.parked);
    if (kind != PointClass::kStatic) continue;
    count(score.all_static);
    if (std::abs(p_sensor.y()) < kLabelledSlope * p_sensor.x()) count(score.seen_static);
  }
}

double DriveScore::associated_accuracy() const {
  return evermap::associated_accuracy(all_static.value(), removed());
}

double DriveScore::harmonic_accuracy() const {
  return evermap::harmonic_accuracy(all_static.value(), removed());
}

}  // namespace evermap
