// SPDX-FileCopyrightText: 2026 the evermap authors
// SPDX-License-Identifier: BSD-3-Clause
#include "posed_scans.hpp"

#include <algorithm>
#include <string>
#include <utility>

#include <spdlog/spdlog.h>

#include <evermap/files/file_error.hpp>
#include <evermap/io/detail/point_time.hpp>

namespace evermap {

std::vector<StampedPose> read_trajectory(const std::filesystem::path& path) {
  PoseFile file = read_poses(path);
  if (file.seconds_per_tick != 1)
    spdlog::warn("{}: its times were taken for {}", path.string(), name_of_unit(file.seconds_per_tick));
  return std::move(file.poses);
}

PosedScans::PosedScans(const std::filesystem::path& scans, const std::filesystem::path& poses,
                       const CloudOptions& cloud)
    : scans_(scans, cloud), poses_(read_trajectory(poses)) {
  if (poses_.size() == scans_.size()) return;
  throw FileError(poses, "has " + std::to_string(poses_.size()) + " poses for the " +
                             std::to_string(scans_.size()) + " scans of " + scans.string() +
                             "; give one pose for each scan");
}

std::vector<Pose> PosedScans::poses() const {
  std::vector<Pose> poses(poses_.size());
  std::transform(poses_.begin(), poses_.end(), poses.begin(),
                 [](const StampedPose& p) { return p.T_map_sensor; });
  return poses;
}

std::optional<PosedScan> PosedScans::next() {
  std::optional<Scan> scan = scans_.next();
  if (!scan) return std::nullopt;
  const std::size_t index = position_++;
  return PosedScan{std::move(*scan), poses_[index].T_map_sensor, scans_.file(index)};
}

}  // namespace evermap
