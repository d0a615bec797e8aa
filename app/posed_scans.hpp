// SPDX-FileCopyrightText: 2026 the evermap authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <filesystem>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include <evermap/bags/scan_bag.hpp>
#include <evermap/geometry/detail/trajectory.hpp>
#include <evermap/geometry/pose.hpp>
#include <evermap/io/poses.hpp>

namespace evermap {

/// read_poses(), and a word about the unit of its times where that is not the second.
std::vector<StampedPose> read_trajectory(const std::filesystem::path& path);

/// Where poses for scans come from: a file, or the recording of the scans itself. A file's poses belong to
/// the scans by their times where both have times, otherwise one to one.
class ScanPoses {
 public:
  /// `poses`: a file, or, if there is none of that name and `scans` is a bag, a topic or a frame in it; empty
  /// for no poses. Changes `options` such that a source opened with them tells the poses of the bag.
  ScanPoses(std::string poses, const std::filesystem::path& scans, ScanOptions& options);
  /// The frame odom of a bag, should it tell one.
  static ScanPoses odometry_of(const std::filesystem::path& scans, ScanOptions& options);

  /// Joins scans and poses; call with the first scan, before asking. Throws FileError when their number
  /// differs from that of a file's poses and times do not join them.
  void match(const ScanSource& scans, const std::filesystem::path& path, const Scan& first);

  bool empty() const { return poses_.empty() && !is_in_bag_; }
  /// A file's poses where they belong to the scans one to one, otherwise none.
  std::vector<Pose> one_to_one() const;
  /// [s] When the last scan of `scans` ended, where the file tells; and of the sensor then, where that is
  /// known.
  std::optional<double> time(const ScanSource& scans) const;
  std::optional<Pose> end_of(const Scan& scan, const ScanSource& scans) const;
  /// And when it began; `scan_period` [s] where no times tell how far apart the poses are.
  std::optional<Pose> begin_of(const Scan& scan, const ScanSource& scans, double scan_period) const;

 private:
  ScanPoses() = default;
  const StampedPose* one_of(const ScanSource& scans) const;

  std::string name_;
  bool is_in_bag_ = false;
  std::vector<StampedPose> poses_;
  Trajectory trajectory_;  ///< the same, when they belong to the scans by time
};

struct PosedScan {
  Scan scan;
  Pose T_map_sensor;                       ///< when it ended
  std::optional<Pose> T_map_sensor_begin;  ///< when it began; of a scan whose points have times
  std::size_t index = 0;                   ///< in the sequence, with those that were left out
  std::string place;                       ///< where it was found, for messages
};

/// Scans with given poses. These win over poses in the scans' files.
class PosedScans {
 public:
  /// Throws FileError when scans or poses cannot be read or do not belong together.
  PosedScans(const std::filesystem::path& scans, const std::string& poses, double scan_period,
             ScanOptions options = {});

  std::size_t size() const { return scans_->size(); }
  const Pose& first_pose() const { return first_->T_map_sensor; }
  /// Of all scans, where they are known before the scans are read; otherwise none.
  std::vector<Pose> poses() const { return poses_.one_to_one(); }
  /// The next scan that has a pose.
  std::optional<PosedScan> next();
  /// What was made of the last scan.
  const CloudNotes& notes() const { return scans_->notes(); }
  std::vector<std::string> remarks() const;
  std::string failure() const { return scans_->failure(); }

 private:
  std::optional<PosedScan> read();

  double scan_period_;  ///< [s]
  ScanPoses poses_;
  std::unique_ptr<ScanSource> scans_;
  std::filesystem::path path_;
  bool is_matched_ = false;
  std::size_t without_pose_ = 0;  ///< scans
  std::optional<PosedScan> first_;
  bool is_first_given_ = false;
};

}  // namespace evermap
