// SPDX-FileCopyrightText: 2026 the evermap authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <deque>

#include <evermap/bags/detail/gyroscope.hpp>
#include <evermap/bags/detail/messages.hpp>
#include <evermap/bags/detail/transform_buffer.hpp>
#include <evermap/bags/scan_bag.hpp>

namespace evermap {

/// The topic of clouds of this name, or the only one when it is empty. Throws FileError when there is none,
/// or it cannot be told which is meant.
std::size_t find_cloud_topic(const BagReader& bag, const std::string& wanted);

/// The clouds of one topic of a bag, with poses from the same bag where they are asked for.
class ScanBag : public ScanSource {
 public:
  ScanBag(const std::filesystem::path& path, const ScanOptions& options);

  std::optional<Scan> next() override;
  std::size_t size() const override { return bag_->topics()[topic_].messages; }
  std::size_t index() const override { return count_ - 1; }
  std::string place() const override;
  const CloudNotes& notes() const override { return now_.notes; }
  std::optional<Pose> pose_at(double time) const override;
  std::optional<Eigen::Matrix3d> rotation_at(double time) const override;
  std::optional<Pose> base_pose() const override;
  std::string frame() const override { return now_.frame; }
  std::vector<std::string> remarks() const override;

 private:
  struct Cloud {
    CloudMessage message;
    double recorded = 0;  ///< [s]
  };

  std::optional<std::size_t> find_reference_topic(const std::string& reference) const;
  /// Reads one more message; false at the end.
  bool read_message();
  bool is_due(const Cloud& cloud) const;
  std::optional<Pose> pose_of(const CloudMessage& cloud, double time) const;

  std::unique_ptr<BagReader> bag_;
  std::size_t topic_;            ///< of the clouds
  std::string base_;             ///< frame; empty when it is not asked for
  std::string reference_frame_;  ///< empty when a topic tells, or nothing is asked for
  std::optional<std::size_t> reference_topic_;
  Trajectory reference_;  ///< T_reference_child of the reference topic
  std::string child_;     ///< of the reference topic; empty when it names none
  std::optional<SensorMount> mount_;
  std::optional<std::size_t> imu_topic_;
  Gyroscope gyroscope_;
  TransformBuffer transforms_;
  std::deque<Cloud> waiting_;  ///< for poses that come later in the bag
  double recorded_ = 0;        ///< [s] of the last message
  std::size_t count_ = 0;      ///< of clouds that were given
  CloudMessage now_;
  double end_ = 0;  ///< [s] of that scan
  bool is_end_told_ = false;
};

}  // namespace evermap
