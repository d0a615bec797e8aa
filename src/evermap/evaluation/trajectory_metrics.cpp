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

/// The distance [m] from the first pose to each.
std::vector<double> distances_along(const std::vector<Pose>& poses) {
  std::vector<double> distances(poses.size(), 0);
  for (std::size_t i = 1; i < poses.size(); ++i) {
    distances[i] = distances[i - 1] + (poses[i].translation - poses[i - 1].translation).norm();
  }
  return distances;
}

/// REQUIRES: times ascend, and there is one.
std::size_t nearest(const std::vector<double>& times, double time) {
  const auto after = std::lower_bound(times.begin(), times.end(), time);
  if (after == times.end()) return times.size() - 1;
  const auto index = static_cast<std::size_t>(after - times.begin());
  return index > 0 && time - times[index - 1] < *after - time ? index - 1 : index;
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

double TrajectoryError::fraction_lost() const {
  std::size_t lost = 0;
  for (std::size_t i = 0; i < translation.size(); ++i) {
    lost += translation[i] > kLostDistance || rotation[i] > kLostAngle ? 1 : 0;
  }
  return static_cast<double>(lost) / static_cast<double>(translation.size());
}

double path_length(const std::vector<Pose>& T_map_sensor) {
  return T_map_sensor.empty() ? 0 : distances_along(T_map_sensor).back();
}

double drift(const std::vector<Pose>& T_map_sensor_true, const std::vector<Pose>& T_map_sensor,
             double stretch) {
  const std::vector<double> along = distances_along(T_map_sensor_true);
  double sum = 0;
  std::size_t stretches = 0;
  for (std::size_t begin = 0, end = 0; begin < along.size(); ++begin) {
    while (end < along.size() && along[end] - along[begin] < stretch) ++end;
    if (end == along.size()) break;
    const Pose truth = T_map_sensor_true[begin].inverse() * T_map_sensor_true[end];
    const Pose found = T_map_sensor[begin].inverse() * T_map_sensor[end];
    sum += (truth.inverse() * found).translation.norm() / stretch;
    ++stretches;
  }
  return stretches == 0 ? kNothing : sum / static_cast<double>(stretches);
}

std::vector<PosePair> match_times(const std::vector<double>& found, const std::vector<double>& truth,
                                  double tolerance) {
  std::vector<PosePair> pairs;
  if (truth.empty()) return pairs;
  for (std::size_t i = 0; i < found.size(); ++i) {
    const std::size_t k = nearest(truth, found[i]);
    const bool is_near = std::abs(found[i] - truth[k]) <= tolerance;
    if (is_near && nearest(found, truth[k]) == i) pairs.push_back({i, k});
  }
  return pairs;
}

}  // namespace evermap
