// SPDX-FileCopyrightText: 2026 the evermap authors
// SPDX-License-Identifier: BSD-3-Clause
#include <algorithm>
#include <array>
#include <string_view>
#include <utility>

#include <Eigen/Geometry>

#include <evermap/maintenance/detail/pose_check.hpp>
#include <evermap/scan/detail/ray_bundle.hpp>
#include <evermap/update/detail/map_updater.hpp>

namespace evermap {
namespace {

using Poses = std::vector<Pose>;

/// T_camera_lidar of a camera in the LiDAR's place that looks along its x axis.
Pose camera_axes() {
  return {(Eigen::Matrix3d() << 0, -1, 0, 0, 0, -1, 1, 0, 0).finished(), Eigen::Vector3d::Zero()};
}

Pose of_camera(const Poses& poses, std::size_t scan) { return poses[scan] * camera_axes(); }
Pose of_camera_from_its_first(const Poses& poses, std::size_t scan) {
  const Pose T_first_now = poses.front().inverse() * poses[scan];
  return poses.front() * camera_axes().inverse() * T_first_now * camera_axes();
}
Pose inverted(const Poses& poses, std::size_t scan) { return poses[scan].inverse(); }
Pose with_w_last(const Poses& poses, std::size_t scan) {
  const Eigen::Quaterniond read(poses[scan].rotation);  // x y z w, of what was written as w x y z
  const Eigen::Quaterniond meant(read.x(), read.y(), read.z(), read.w());
  return {meant.toRotationMatrix(), poses[scan].translation};
}
Pose mirrored(const Poses& poses, std::size_t scan) {
  const Eigen::Matrix3d mirror = Eigen::Vector3d(1, -1, 1).asDiagonal();
  return {mirror * poses[scan].rotation * mirror, mirror * poses[scan].translation};
}
Pose of_scan_before(const Poses& poses, std::size_t scan) { return poses[scan > 0 ? scan - 1 : 0]; }
Pose of_scan_after(const Poses& poses, std::size_t scan) {
  return poses[std::min(scan + 1, poses.size() - 1)];
}
/// Where the pose of scan 2 stands when 10 was sorted before it.
Pose sorted_as_numbers(const Poses& poses, std::size_t scan) {
  const std::string name = std::to_string(scan);
  std::size_t before = 0;
  for (std::size_t other = 0; other < poses.size(); ++other) before += std::to_string(other) < name ? 1 : 0;
  return poses[std::min(before, poses.size() - 1)];
}

struct Mistake {
  Pose (*mended)(const Poses&, std::size_t scan);
  std::string_view words;
};
constexpr std::string_view kOfACamera =
    "they are of a camera, whose z axis looks ahead; give those of the LiDAR, or its extrinsic or "
    "calibration";
constexpr std::string_view kAScanApart = "they are a scan early or late";
constexpr std::array<Mistake, 8> kMistakes = {{
    {of_camera, kOfACamera},
    {of_camera_from_its_first, kOfACamera},
    {inverted, "they map from the map to the sensor; give their inverse"},
    {with_w_last, "their quaternions begin with w; write qx qy qz qw"},
    {mirrored, "their y axis points the other way than that of the scans"},
    {of_scan_before, kAScanApart},
    {of_scan_after, kAScanApart},
    {sorted_as_numbers, "they, or the scans, were sorted by name, 10 before 2"},
}};

constexpr double kFits = 0.8;  ///< of a scan's bundles on the map: nothing else needs to be tried

}  // namespace

PoseCheck::PoseCheck(const Octree& map, const LidarParameters& lidar, std::vector<Pose> poses)
    : maps_(map.empty() ? 1 + kMistakes.size() : 1, map),
      is_growing_(map.empty()),
      lidar_(lidar),
      poses_(std::move(poses)),
      mended_fit_(kMistakes.size(), 0) {}

void PoseCheck::note(std::size_t scan, const Pose& T_map_sensor) {
  if (scan >= poses_.size()) poses_.resize(scan + 1, T_map_sensor);
}

bool PoseCheck::wants(std::size_t scan) {
  constexpr std::size_t kAtFirst = 8;
  constexpr std::size_t kThen = 16;
  // Scans from one place lie on each other whatever is wrong with its pose.
  const bool is_wanted =
      is_growing_ ? seen_ < kAtFirst && has_moved(scan) : asked_ < kAtFirst || asked_ % kThen == 0;
  ++asked_;
  if (is_wanted) last_ = scan;
  return is_wanted;
}

bool PoseCheck::has_moved(std::size_t scan) const {
  if (!last_) return true;
  const double way = std::max(1.0, 2 * maps_.front().grid().edge);  // [m]
  return (poses_[scan].translation - poses_[*last_].translation).norm() > way;
}

double PoseCheck::fit(const Octree& map, const Scan& points, const Pose& T_map_sensor) const {
  const BundleGrid grid = condense(points, T_map_sensor, map.grid(), lidar_);
  if (grid.bundles().empty()) return 0;
  const auto on_map =
      std::count_if(grid.bundles().begin(), grid.bundles().end(), [&](const RayBundle& bundle) {
        const Leaf* leaf = map.find(bundle.key);
        if (leaf == nullptr || !leaf->occupied()) return false;
        Gaussian surface = map.gaussian(bundle.key, *leaf);
        surface.covariance += bundle.points.covariance;
        return mahalanobis_squared(bundle.points.mean, surface) < kChiSquared99;
      });
  return static_cast<double>(on_map) / static_cast<double>(grid.bundles().size());
}

void PoseCheck::add(std::size_t scan, const Scan& points, double contradicting) {
  if (!maps_.front().empty()) {
    ++seen_;
    contradicting_ += contradicting;
    const double given = fit(maps_.front(), points, poses_[scan]);
    fit_ += given;
    for (std::size_t i = 0; i < kMistakes.size(); ++i) {
      mended_fit_[i] +=
          given > kFits ? given : fit(map_without(i), points, kMistakes[i].mended(poses_, scan));
    }
  }
  if (!is_growing_) return;
  for (std::size_t i = 0; i < maps_.size(); ++i) {
    const Pose T_map_sensor = i == 0 ? poses_[scan] : kMistakes[i - 1].mended(poses_, scan);
    evermap::add(maps_[i], condense(points, T_map_sensor, maps_[i].grid(), lidar_), {});
  }
}

std::string PoseCheck::verdict() const {
  constexpr std::size_t kEnough = 3;  // scans
  if (seen_ < kEnough) return {};
  const auto n = static_cast<double>(seen_);
  const auto best = std::max_element(mended_fit_.begin(), mended_fit_.end());
  const auto percent = [n](double sum) { return std::to_string(static_cast<int>(100 * sum / n)) + " %"; };
  const std::string misfit =
      std::string(is_growing_ ? "the scans do not lie on each other where their poses put them ("
                              : "the scans do not lie on the map where their poses put them (") +
      percent(fit_) + ")";
  constexpr double kClearly = 0.8;  // of the best
  // The first scans of few beams lie on each other in a third of the places at most.
  const bool is_clear = *best > 0.5 * n && fit_ < kClearly * *best;
  const bool is_clear_of_few = is_growing_ && *best > 0.1 * n && fit_ < 0.5 * *best;
  if (is_clear || is_clear_of_few) {
    const Mistake& mistake = kMistakes[static_cast<std::size_t>(best - mended_fit_.begin())];
    return misfit + " and do (" + percent(*best) + ") if " + std::string(mistake.words);
  }
  constexpr double kMuch = 0.15;
  if (fit_ < 0.3 * n && contradicting_ > kMuch * n)
    return misfit + ", and " + percent(contradicting_) +
           " of their rays contradict it; are poses and map of this drive?";
  return {};
}

}  // namespace evermap
