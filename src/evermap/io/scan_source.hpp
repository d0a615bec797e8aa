// SPDX-FileCopyrightText: 2026 the evermap authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstddef>
#include <optional>
#include <string>
#include <vector>

#include <evermap/geometry/pose.hpp>
#include <evermap/io/detail/cloud_notes.hpp>
#include <evermap/scan/scan.hpp>

namespace evermap {

/// A sequence of scans, read one at a time. Not thread safe.
class ScanSource {
 public:
  virtual ~ScanSource() = default;

  /// The next scan, none after the last. Throws FileError when it is damaged.
  virtual std::optional<Scan> next() = 0;
  /// How many scans there are, as far as that is known before they are read.
  virtual std::size_t size() const = 0;

  /// The number of the last scan, from 0, counted with those that were left out.
  virtual std::size_t index() const = 0;
  /// Where the last scan was found, for messages.
  virtual std::string place() const = 0;
  /// What was made of the last scan.
  virtual const CloudNotes& notes() const = 0;
  /// Where the sensor was at a time [s] during the last scan, in the frame that was asked for; none when the
  /// recording does not tell.
  virtual std::optional<Pose> pose_at(double /*time*/) const { return std::nullopt; }
  /// R_inertial_sensor at a time [s] during the last scan, by a gyroscope; none when the recording does not
  /// tell.
  virtual std::optional<Eigen::Matrix3d> rotation_at(double /*time*/) const { return std::nullopt; }
  /// T_sensor_base: where the base that was asked for is in the frame of the last scan; none when the
  /// recording does not tell.
  virtual std::optional<Pose> base_pose() const { return std::nullopt; }
  /// The frame of the last scan's points; empty when the recording does not tell.
  virtual std::string frame() const { return {}; }
  /// What is to be known of what was read up to now, a sentence each: damage that ended it, what was assumed.
  virtual std::vector<std::string> remarks() const { return {}; }
  /// Why it was given up before its end, in one line; empty as long as it was not.
  virtual std::string failure() const { return {}; }
};

}  // namespace evermap
