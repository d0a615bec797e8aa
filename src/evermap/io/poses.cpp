// SPDX-FileCopyrightText: 2026 the evermap authors
// SPDX-License-Identifier: BSD-3-Clause
#include <algorithm>
#include <cmath>
#include <locale>
#include <sstream>
#include <string>
#include <utility>

#include <evermap/files/detail/text_lines.hpp>
#include <evermap/io/detail/atomic_file.hpp>
#include <evermap/io/detail/pose_log.hpp>
#include <evermap/io/detail/quaternion.hpp>
#include <evermap/io/poses.hpp>

namespace evermap {
namespace {

constexpr std::size_t kTumColumns = 8;
constexpr std::size_t kKittiColumns = 12;
constexpr double kRotationTolerance = 1e-3;  // data sets print six digits and more; a slip is far larger

bool are_finite(const std::vector<double>& values) {
  return std::all_of(values.begin(), values.end(), [](double value) { return std::isfinite(value); });
}

StampedPose tum_pose(const std::vector<double>& row, const TextLines& lines) {
  const Eigen::Quaterniond quaternion(row[7], row[4], row[5], row[6]);
  const std::optional<Eigen::Matrix3d> rotation = rotation_from_file(quaternion);
  if (!rotation) {
    lines.fail("the quaternion qx qy qz qw has norm " + std::to_string(quaternion.norm()) +
               ", not 1; correct it");
  }
  return {row[0], {*rotation, {row[1], row[2], row[3]}}};
}

StampedPose kitti_pose(const std::vector<double>& row, const TextLines& lines) {
  const auto matrix = Eigen::Map<const Eigen::Matrix<double, 3, 4, Eigen::RowMajor>>(row.data());
  const Eigen::Matrix3d rotation = matrix.leftCols<3>();
  if (!is_rotation(rotation, kRotationTolerance)) {
    lines.fail("the left 3x3 block of the row-major 3x4 matrix is no rotation; correct it");
  }
  return {std::nullopt, {nearest_rotation(rotation), matrix.col(3)}};
}

/// What 1 of a trajectory's times is [s].
double unit_of(const std::vector<StampedPose>& poses) {
  constexpr double kNever = 1e11;   // [s] since 1970, or since anything else
  constexpr double kLongStep = 20;  // [s] from pose to pose; few follow each other in a thousandth of it
  std::vector<double> steps;
  for (std::size_t i = 1; i < poses.size(); ++i) steps.push_back(*poses[i].time - *poses[i - 1].time);
  if (steps.empty()) return 1;
  const auto middle = steps.begin() + static_cast<std::ptrdiff_t>(steps.size() / 2);
  std::nth_element(steps.begin(), middle, steps.end());
  const double latest = std::abs(*poses.back().time);
  for (const double unit : {1.0, 1e-3, 1e-6}) {
    if (*middle * unit < kLongStep && latest * unit < kNever) return unit;
  }
  return 1e-9;
}

bool is_plausible(const StampedPose& pose) {
  constexpr double kFarthest = 1e8;  // [m] beyond what any frame of the earth needs, and where doubles fade
  constexpr double kLatest = 1e19;   // nanoseconds of three centuries
  return pose.T_map_sensor.translation.cwiseAbs().maxCoeff() <= kFarthest &&
         std::abs(pose.time.value_or(0)) <= kLatest;
}

}  // namespace

PoseFile read_poses(const std::filesystem::path& path) {
  const InputFile file(path);
  TextLines lines(file);
  std::vector<StampedPose> poses;
  std::vector<double> row;
  std::size_t columns = 0;
  while (lines.next_filled()) {
    std::string_view rest = lines.line();
    if (next_token(rest).starts_with('#')) continue;
    lines.read_numbers(row);
    if (poses.empty()) columns = row.size();
    if (row.size() != columns || (columns != kTumColumns && columns != kKittiColumns)) {
      lines.fail(
          "has " + std::to_string(row.size()) +
          " numbers; every line needs 8 (TUM: t x y z qx qy qz qw) or every line 12 (KITTI: 3x4 matrix)");
    }
    if (!are_finite(row)) lines.fail("holds a number that is not finite; remove the line and its scan");
    poses.push_back(columns == kTumColumns ? tum_pose(row, lines) : kitti_pose(row, lines));
    if (!is_plausible(poses.back())) {
      lines.fail("holds a time or a place that no drive reaches (1e8 m from the origin); correct the line");
    }
    if (poses.size() > 1 && poses.back().time && *poses.back().time <= *poses[poses.size() - 2].time) {
      lines.fail("the time is not later than that of the pose before; sort the poses, remove doubles");
    }
  }
  if (poses.empty()) file.fail("holds no pose");
  if (columns == kKittiColumns) return {std::move(poses)};
  const double unit = unit_of(poses);
  for (StampedPose& pose : poses) *pose.time *= unit;
  return {std::move(poses), unit};
}

SensorMount read_kitti_calibration(const std::filesystem::path& path) {
  const InputFile file(path);
  TextLines lines(file);
  std::vector<double> transform, rotation, translation;
  while (lines.next_filled()) {
    std::string_view rest = lines.line();
    const std::string_view key = next_token(rest);
    std::vector<double>* const values = key == "Tr:"  ? &transform
                                        : key == "R:" ? &rotation
                                        : key == "T:" ? &translation
                                                      : nullptr;
    if (values == nullptr) continue;
    lines.read_numbers(rest, *values);
    if (!are_finite(*values)) lines.fail("nan or infinity is no number of a calibration; correct it");
  }
  if (transform.empty() && rotation.size() == 9 && translation.size() == 3) {
    for (std::size_t row = 0; row < 3; ++row) {
      transform.insert(transform.end(), rotation.begin() + static_cast<std::ptrdiff_t>(3 * row),
                       rotation.begin() + static_cast<std::ptrdiff_t>(3 * row + 3));
      transform.push_back(translation[row]);
    }
  }
  if (transform.size() != kKittiColumns) {
    file.fail(
        "holds no line \"Tr:\" of 12 numbers (3x4), nor \"R:\" of 9 and \"T:\" of 3; is it a calib.txt of "
        "KITTI?");
  }
  const Pose T_camera_lidar = kitti_pose(transform, lines).T_map_sensor;
  return {T_camera_lidar, T_camera_lidar.inverse()};
}

void write_tum_poses(const std::filesystem::path& path, const std::vector<StampedPose>& poses) {
  AtomicFile file(path);
  for (const StampedPose& pose : poses) file.write(tum_row(path, pose));
  file.commit();
}

void write_kitti_poses(const std::filesystem::path& path, const std::vector<StampedPose>& poses) {
  AtomicFile file(path);
  std::ostringstream rows;
  rows.imbue(std::locale::classic());
  rows.precision(12);
  for (const StampedPose& pose : poses) {
    const auto& [rotation, translation] = pose.T_map_sensor;
    for (int row = 0; row < 3; ++row) {
      rows << (row > 0 ? " " : "") << rotation(row, 0) << " " << rotation(row, 1) << " " << rotation(row, 2)
           << " " << translation[row];
    }
    rows << "\n";
  }
  file.write(rows.str());
  file.commit();
}

}  // namespace evermap
