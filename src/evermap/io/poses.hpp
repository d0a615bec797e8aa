// SPDX-FileCopyrightText: 2026 the evermap authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <filesystem>
#include <optional>
#include <vector>

#include <evermap/geometry/pose.hpp>

namespace evermap {

/// One row of a trajectory file.
struct StampedPose {
  std::optional<double> time;  ///< [s] none in a KITTI file, which has no times
  Pose T_map_sensor;
};

/// The rows of a trajectory file, and what its times were taken for.
struct PoseFile {
  std::vector<StampedPose> poses;
  double seconds_per_tick = 1;  ///< of the times as written; 1, 1e-3, 1e-6 or 1e-9
};

/// Reads TUM (`t x y z qx qy qz qw`) or KITTI (12 numbers, row-major 3x4) poses; the number of columns tells
/// which. Blank lines and lines that begin with `#` are skipped. Quaternions are normalized, matrices
/// replaced by the nearest rotation. Throws FileError naming the line for: another number of columns,
/// something that is no finite number, a quaternion of norm 0 (or further than 1e-2 from 1), a matrix that is
/// no rotation (tolerance 1e-3), time not strictly increasing; and without a line for a file that cannot be
/// read or holds no pose. Times may be in seconds, milliseconds, microseconds or nanoseconds: what they are
/// is told by their steps, which are taken for less than 20 s.
PoseFile read_poses(const std::filesystem::path& path);

/// Where a sensor is on what poses are of, and in which frame they are: T_map_sensor = T_map_reference *
/// T_reference_base * T_base_sensor.
struct SensorMount {
  Pose T_base_sensor;
  Pose T_map_reference;

  Pose sensor_of(const Pose& T_reference_base) const {
    return T_map_reference * T_reference_base * T_base_sensor;
  }
};

/// Reads a KITTI calibration: `calib.txt` of the odometry benchmark (`Tr:`, 3x4) or `calib_velo_to_cam.txt`
/// of the raw data (`R:`, 3x3, and `T:`). Poses of the camera, in the frame of its first one, become poses
/// of the LiDAR in its own first frame, whose z axis points up. Throws FileError.
SensorMount read_kitti_calibration(const std::filesystem::path& path);

/// Writes TUM poses atomically, times with six decimals. Throws FileError when the file cannot be written.
/// REQUIRES: every pose has a time.
void write_tum_poses(const std::filesystem::path& path, const std::vector<StampedPose>& poses);
/// The same as KITTI's rows, which have no times.
void write_kitti_poses(const std::filesystem::path& path, const std::vector<StampedPose>& poses);

}  // namespace evermap
