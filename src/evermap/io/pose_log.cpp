// SPDX-FileCopyrightText: 2026 the evermap authors
// SPDX-License-Identifier: BSD-3-Clause
#include <array>
#include <cerrno>
#include <cstdio>
#include <fcntl.h>
#include <system_error>
#include <unistd.h>
#include <utility>

#include <evermap/files/detail/descriptor.hpp>
#include <evermap/files/file_error.hpp>
#include <evermap/io/detail/pose_log.hpp>

namespace evermap {
namespace {

void check_log(const std::filesystem::path& path, int error) {
  if (error != 0) throw FileError(path, "cannot be written: " + std::generic_category().message(error));
}

}  // namespace

std::string tum_row(const std::filesystem::path& path, const StampedPose& pose) {
  // The longest number that %.6f prints has 317 characters, %.12g 19.
  std::array<char, 512> row{};
  const Eigen::Vector3d& t = pose.T_map_sensor.translation;
  const Eigen::Quaterniond q(pose.T_map_sensor.rotation);
  const int size = std::snprintf(row.data(), row.size(), "%.6f %.9g %.9g %.9g %.12g %.12g %.12g %.12g\n",
                                 pose.time.value(), t.x(), t.y(), t.z(), q.x(), q.y(), q.z(), q.w());
  const bool is_whole = size > 0 && static_cast<std::size_t>(size) < row.size();
  if (!is_whole) throw FileError(path, "a pose cannot be written as a line");
  return {row.data(), static_cast<std::size_t>(size)};
}

std::filesystem::path PoseLog::path_of(const std::filesystem::path& poses) {
  return poses.string() + ".part";
}

PoseLog::PoseLog(const std::filesystem::path& poses) : path_(path_of(poses)) {
  descriptor_ = open_descriptor(path_, O_WRONLY | O_CREAT | O_TRUNC);
  check_log(path_, descriptor_ < 0 ? errno : 0);
}

PoseLog::~PoseLog() {
  ::close(descriptor_);
  if (written_ == 0) ::unlink(path_.c_str());
}

void PoseLog::extend(const std::vector<StampedPose>& trajectory) {
  std::string rows;
  for (; written_ < trajectory.size(); ++written_) rows += tum_row(path_, trajectory[written_]);
  check_log(path_, write_all(descriptor_, rows));
}

void PoseLog::sync() { check_log(path_, sync_to_device(descriptor_)); }

void PoseLog::discard() { ::unlink(path_.c_str()); }

}  // namespace evermap
