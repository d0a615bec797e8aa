// SPDX-FileCopyrightText: 2026 the evermap authors
// SPDX-License-Identifier: BSD-3-Clause
#include <algorithm>
#include <cmath>
#include <cstddef>
#include <limits>

#include <Eigen/Geometry>

#include <evermap/evaluation/trajectory_metrics.hpp>

namespace evermap {
namespace {

constexpr double kNothing = std::numeric_limits<double>::quiet_NaN();

double rmse(const std::vector<double>& errors) {
  double sum = 0;
  for (const double error : errors) sum += error * error;
  return std::sqrt(sum / static_cast<double>(errors.size()));
}

double maximum(const std::vector<double>& errors) {
  return errors.empty() ? kNothing : *std::max_element(errors.begin(), errors.end());
}

Eigen::Matrix3Xd positions(const std::vector<Pose>& poses) {
  Eigen::Matrix3Xd columns(3, static_cast<Eigen::Index>(poses.size()));
  for (std::size_t i = 0; i < poses.size(); ++i) {
    columns.col(static_cast<Eigen::Index>(i)) = poses[i].translation;
  }
  return columns;
}

double aligned_rmse(const std::vector<Pose>& truth, const std::vector<Pose>& estimate) {
  if (truth.empty()) return kNothing;
  constexpr bool kWithScale = false;
  const Eigen::Matrix3Xd to = positions(truth);
  const Eigen::Matrix3Xd from = positions(estimate);
  const Eigen::Matrix4d T = Eigen::umeyama(from, to, kWithScale);
  const Eigen::Matrix3Xd moved = (T.topLeftCorner<3, 3>() * from).colwise() + T.topRightCorner<3, 1>();
  return std::sqrt((moved - to).squaredNorm() / static_cast<double>(truth.size()));
}

/// From the quaternion, because the arc cosine of the trace knows small angles to 1e-8 rad only.
double angle(const Eigen::Matrix3d& rotation) {
  return Eigen::Quaterniond(rotation).angularDistance(Eigen::Quaterniond::Identity());
}

}  // namespace

TrajectoryError compare_trajectories(const std::vector<Pose>& T_map_sensor_true,
                                     const std::vector<Pose>& T_map_sensor) {
  TrajectoryError error{{}, {}, aligned_rmse(T_map_sensor_true, T_map_sensor)};
  for (std::size_t i = 0; i < T_map_sensor.size(); ++i) {
    const Pose& truth = T_map_sensor_true[i];
    error.translation.push_back((T_map_sensor[i].translation - truth.translation).norm());
    error.rotation.push_back(angle(truth.rotation.transpose() * T_map_sensor[i].rotation));
  }
  return error;
}

double TrajectoryError::translation_rmse() const { return rmse(translation); }
double TrajectoryError::translation_max() const { return maximum(translation); }
double TrajectoryError::rotation_rmse() const { return rmse(rotation); }
double TrajectoryError::rotation_max() const { return maximum(rotation); }

double TrajectoryError::share_lost() const {
  std::size_t lost = 0;
  for (std::size_t i = 0; i < translation.size(); ++i) {
    lost += translation[i] > kLostDistance || rotation[i] > kLostAngle ? 1 : 0;
  }
  return static_cast<double>(lost) / static_cast<double>(translation.size());
}

}  // namespace evermap
