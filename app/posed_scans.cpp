// SPDX-FileCopyrightText: 2026 the evermap authors
// SPDX-License-Identifier: BSD-3-Clause
#include "posed_scans.hpp"

#include <algorithm>
#include <utility>

#include <fmt/format.h>
#include <spdlog/spdlog.h>

#include <evermap/files/file_error.hpp>
#include <evermap/io/detail/point_time.hpp>
#include <evermap/scan/detail/deskew.hpp>

namespace evermap {

std::vector<StampedPose> read_trajectory(const std::filesystem::path& path) {
  PoseFile file = read_poses(path);
  if (file.seconds_per_tick != 1)
    spdlog::warn("{}: its times were taken for {}", path.string(), name_of_unit(file.seconds_per_tick));
  return std::move(file.poses);
}

ScanPoses::ScanPoses(std::string poses, const std::filesystem::path& scans, ScanOptions& options)
    : name_(std::move(poses)) {
  if (name_.empty()) return;
  is_in_bag_ = is_bag(scans) && !std::filesystem::exists(name_);
  if (is_in_bag_) {
    options.reference = name_;
  } else {
    poses_ = read_trajectory(name_);
    if (!options.mount) return;
    for (StampedPose& pose : poses_) pose.T_map_sensor = options.mount->sensor_of(pose.T_map_sensor);
  }
}

ScanPoses ScanPoses::odometry_of(const std::filesystem::path& scans, ScanOptions& options) {
  ScanPoses odometry;
  odometry.is_in_bag_ = is_bag(scans);
  if (odometry.is_in_bag_) {
    options.reference = "odom";
    options.is_reference_needed = false;
  }
  return odometry;
}

void ScanPoses::match(const ScanSource& scans, const std::filesystem::path& path, const Scan& first) {
  if (poses_.empty()) return;
  if (first.time && poses_.front().time) {
    constexpr double kNear = 60;  // [s] a drive may begin before its poses
    const double from = *poses_.front().time;
    const double to = *poses_.back().time;
    if (*first.time > from - kNear && *first.time < to + kNear) {
      for (const StampedPose& pose : poses_) trajectory_.add(*pose.time, pose.T_map_sensor);
      return;
    }
    if (poses_.size() != scans.size()) {
      throw FileError(
          name_, fmt::format("its poses are of {:.3f} to {:.3f} s, the first scan of {} ended at {:.3f} s; "
                             "give poses of this recording, in its clock",
                             from, to, path.string(), *first.time));
    }
  }
  if (poses_.size() == scans.size()) return;
  throw FileError(name_, fmt::format("has {} poses for the {} scans of {}; give one pose for each scan",
                                     poses_.size(), scans.size(), path.string()));
}

std::vector<Pose> ScanPoses::one_to_one() const {
  std::vector<Pose> poses;
  if (!trajectory_.empty()) return poses;
  poses.reserve(poses_.size());
  for (const StampedPose& pose : poses_) poses.push_back(pose.T_map_sensor);
  return poses;
}

const StampedPose* ScanPoses::one_of(const ScanSource& scans) const {
  return trajectory_.empty() && scans.index() < poses_.size() ? &poses_[scans.index()] : nullptr;
}

std::optional<double> ScanPoses::time(const ScanSource& scans) const {
  const StampedPose* pose = one_of(scans);
  return pose != nullptr ? pose->time : std::nullopt;
}

std::optional<Pose> ScanPoses::end_of(const Scan& scan, const ScanSource& scans) const {
  if (is_in_bag_) return scans.pose_at(*scan.time);
  if (!trajectory_.empty()) return trajectory_.at(*scan.time);
  const StampedPose* pose = one_of(scans);
  return pose != nullptr ? std::optional(pose->T_map_sensor) : std::nullopt;
}

std::optional<Pose> ScanPoses::begin_of(const Scan& scan, const ScanSource& scans, double scan_period) const {
  if (!has_times(scan)) return std::nullopt;
  const double duration = *std::max_element(scan.time_offset.begin(), scan.time_offset.end());
  if (is_in_bag_) return scans.pose_at(*scan.time - duration);
  if (!trajectory_.empty()) return trajectory_.at(*scan.time - duration);
  const StampedPose* pose = one_of(scans);
  if (pose == nullptr || poses_.size() < 2) return std::nullopt;
  // From the pose before it went on steadily; to the first scan it came as it went on.
  const std::size_t before = std::max<std::size_t>(scans.index(), 1) - 1;
  const StampedPose& from = poses_[before];
  const StampedPose& to = poses_[before + 1];
  const double step = from.time && to.time ? *to.time - *from.time : scan_period;
  constexpr double kLongestStep = 2;  // scans; beyond, some were left out, and who knows how it moved
  if (step > kLongestStep * std::max(scan_period, duration)) return std::nullopt;
  const Twist motion = log(from.T_map_sensor.inverse() * to.T_map_sensor);
  return pose->T_map_sensor * exp(-duration / step * motion);
}

PosedScans::PosedScans(const std::filesystem::path& scans, const std::string& poses, double scan_period,
                       ScanOptions options)
    : scan_period_(scan_period),
      poses_(poses, scans, options),
      scans_(open_scans(scans, options)),
      path_(scans) {
  first_ = read();
  if (first_) return;
  throw FileError(scans, without_pose_ > 0
                             ? fmt::format("none of its {} scans has a pose by {}", without_pose_, poses)
                             : "holds no scan that could be read");
}

std::optional<PosedScan> PosedScans::next() {
  if (std::exchange(is_first_given_, true)) return read();
  return *first_;
}

std::optional<PosedScan> PosedScans::read() {
  while (std::optional<Scan> scan = scans_->next()) {
    if (!std::exchange(is_matched_, true)) poses_.match(*scans_, path_, *scan);
    const std::optional<Pose> T_map_sensor = poses_.end_of(*scan, *scans_);
    if (!T_map_sensor) {
      ++without_pose_;
      continue;
    }
    const std::optional<Pose> T_map_sensor_begin = poses_.begin_of(*scan, *scans_, scan_period_);
    return PosedScan{std::move(*scan), *T_map_sensor, T_map_sensor_begin, scans_->index(), scans_->place()};
  }
  return std::nullopt;
}

std::vector<std::string> PosedScans::remarks() const {
  std::vector<std::string> remarks = scans_->remarks();
  if (without_pose_ > 0)
    remarks.push_back(
        fmt::format("{} scans have no pose near their time; they were left out", without_pose_));
  for (std::string& remark : remarks) remark.insert(0, path_.string() + ": ");
  return remarks;
}

}  // namespace evermap
