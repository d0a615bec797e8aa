// SPDX-FileCopyrightText: 2026 the evermap authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <filesystem>
#include <optional>
#include <vector>

#include <evermap/geometry/pose.hpp>
#include <evermap/io/poses.hpp>
#include <evermap/io/scan_source.hpp>

namespace evermap {

/// read_poses(), and a word about the unit of its times where that is not the second.
std::vector<StampedPose> read_trajectory(const std::filesystem::path& path);

struct PosedScan {
  Scan scan;
  Pose T_map_sensor;
  std::filesystem::path file;
};

/// Scans with the poses of a trajectory file, one to one. The trajectory wins over poses in the scans' files.
class PosedScans {
 public:
  /// Throws FileError when one cannot be read or their numbers differ.
  PosedScans(const std::filesystem::path& scans, const std::filesystem::path& poses,
             const CloudOptions& cloud = {});

  std::size_t size() const { return scans_.size(); }
  const Pose& first_pose() const { return poses_.front().T_map_sensor; }
  std::vector<Pose> poses() const;
  std::optional<PosedScan> next();
  /// What was made of the last scan's file.
  const CloudNotes& notes() const { return scans_.notes(); }

 private:
  ScanSource scans_;
  std::vector<StampedPose> poses_;
  std::size_t position_ = 0;
};

}  // namespace evermap
