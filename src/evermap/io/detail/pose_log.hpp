// SPDX-FileCopyrightText: 2026 the evermap authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstddef>
#include <filesystem>
#include <string>
#include <vector>

#include <evermap/io/poses.hpp>

namespace evermap {

/// A pose as a row of a TUM file, with its end of line. Throws FileError naming `path` for numbers that do
/// not fit a row. REQUIRES: it has a time.
std::string tum_row(const std::filesystem::path& path, const StampedPose& pose);

/// The trajectory of a run that is not over, in POSES.part beside the file POSES that it is to become: what a
/// run leaves that is killed, or ends by an error. Throws FileError when it cannot be written. Not thread
/// safe.
class PoseLog {
 public:
  explicit PoseLog(const std::filesystem::path& poses);
  /// Leaves the file, unless it is empty.
  ~PoseLog();
  PoseLog(const PoseLog&) = delete;
  PoseLog& operator=(const PoseLog&) = delete;

  /// POSES.part of POSES.
  static std::filesystem::path path_of(const std::filesystem::path& poses);
  const std::filesystem::path& path() const { return path_; }

  /// Appends what the trajectory has more than at the last call. No end of the process loses it.
  void extend(const std::vector<StampedPose>& trajectory);
  /// Now a power cut does not lose it, either.
  void sync();
  /// Removes the file: the trajectory is where it should be.
  void discard();

 private:
  std::filesystem::path path_;
  int descriptor_ = -1;
  std::size_t written_ = 0;  ///< poses
};

}  // namespace evermap
