// SPDX-FileCopyrightText: 2026 the evermap authors
// SPDX-License-Identifier: BSD-3-Clause
#include <algorithm>
#include <cstring>
#include <utility>

#include <evermap/ros/detail/idl_types.hpp>
#include <evermap/ros/scan_publisher.hpp>
#include <evermap/scan/detail/deskew.hpp>

namespace evermap {
namespace {

// What nobody said of a recording's odometry.
const Eigen::Matrix<double, 6, 6> kUnknown = Eigen::Matrix<double, 6, 6>::Zero();

}  // namespace

class ScanPublisher::Topics {
 public:
  Topics(unsigned domain, bool is_local, const std::string& points, const std::string& odometry_topic)
      : node(domain, is_local),
        clouds(node, points, sensor_msgs_msg_dds__PointCloud2__desc, Delivery::kReliable),
        transforms(node, "/tf", tf2_msgs_msg_dds__TFMessage__desc, Delivery::kReliable),
        static_transforms(node, "/tf_static", tf2_msgs_msg_dds__TFMessage__desc, Delivery::kLatched),
        odometry(node, odometry_topic, nav_msgs_msg_dds__Odometry__desc, Delivery::kReliable),
        imu(node, "/imu", sensor_msgs_msg_dds__Imu__desc, Delivery::kSensorData),
        clock(node, "/clock", rosgraph_msgs_msg_dds__Clock__desc, Delivery::kSensorData),
        initial_pose(node, "/initialpose", geometry_msgs_msg_dds__PoseWithCovarianceStamped__desc,
                     Delivery::kReliable),
        others(node, "/tf", tf2_msgs_msg_dds__TFMessage__desc, Delivery::kReliable, 100) {}

  DdsNode node;
  DdsWriter clouds;
  DdsWriter transforms;
  DdsWriter static_transforms;
  DdsWriter odometry;
  DdsWriter imu;
  DdsWriter clock;
  DdsWriter initial_pose;
  DdsReader others;                       ///< transforms of other nodes
  std::vector<StampedTransform> statics;  ///< all that were sent
};

ScanPublisher::ScanPublisher(unsigned domain, bool is_local, const std::string& points,
                             const std::string& odometry)
    : topics_(std::make_unique<Topics>(domain, is_local, points, odometry)) {}
ScanPublisher::~ScanPublisher() = default;

void ScanPublisher::send_cloud(const Scan& scan, const std::string& frame) {
  const bool is_timed = has_times(scan);
  const std::size_t values = is_timed ? 4 : 3;
  std::vector<std::uint8_t> data(scan.p_sensor.size() * values * sizeof(float));
  float latest = 0;  // [s]
  for (std::size_t i = 0; i < scan.p_sensor.size(); ++i) {
    const Eigen::Vector3f p = scan.p_sensor[i].cast<float>();
    std::uint8_t* point = data.data() + i * values * sizeof(float);
    std::memcpy(point, p.data(), 3 * sizeof(float));
    if (!is_timed) continue;
    std::memcpy(point + 3 * sizeof(float), &scan.time_offset[i], sizeof(float));
    latest = std::max(latest, scan.time_offset[i]);
  }
  std::vector<PointField> fields = {{"x"}, {"y"}, {"z"}};
  if (is_timed) fields.push_back({"time"});
  // Drivers stamp the begin of a sweep, from which its points' times count.
  send(topics_->clouds, *scan.time - latest, frame, fields, data);
}

void ScanPublisher::send_transforms(const std::vector<StampedTransform>& transforms, bool is_static) {
  if (!is_static) return send(topics_->transforms, transforms);
  for (const StampedTransform& transform : transforms) {
    std::erase_if(topics_->statics,
                  [&](const StampedTransform& old) { return old.child == transform.child; });
    topics_->statics.push_back(transform);
  }
  send(topics_->static_transforms, topics_->statics);
}

void ScanPublisher::send_odometry(const StampedTransform& pose) { send(topics_->odometry, pose, kUnknown); }

void ScanPublisher::send_turn_rate(const TurnRate& rate) {
  sensor_msgs_msg_dds__Imu_ message{};
  message.header = header_of(rate.time, rate.frame);
  message.orientation.w = 1;
  message.orientation_covariance[0] = -1;          // unknown
  message.linear_acceleration_covariance[0] = -1;  // likewise
  message.angular_velocity = {rate.rate.x(), rate.rate.y(), rate.rate.z()};
  topics_->imu.write(&message);
}

void ScanPublisher::send_clock(double time) {
  const rosgraph_msgs_msg_dds__Clock_ message{stamp_of(time)};
  topics_->clock.write(&message);
}

void ScanPublisher::send_initial_pose(const StampedTransform& pose) {
  const geometry_msgs_msg_dds__PoseWithCovarianceStamped_ message{
      header_of(pose.time, pose.parent), with_covariance(pose.T_parent_child, kUnknown)};
  topics_->initial_pose.write(&message);
}

std::vector<StampedTransform> ScanPublisher::listen(double seconds) {
  topics_->node.wait(seconds);
  std::vector<StampedTransform> heard;
  for (const DdsMessage& message : topics_->others.take()) {
    for (StampedTransform& one : read_transforms(topics_->others.topic(), message.bytes))
      heard.push_back(std::move(one));
  }
  return heard;
}

std::size_t ScanPublisher::listeners() const { return topics_->clouds.readers(); }

}  // namespace evermap
