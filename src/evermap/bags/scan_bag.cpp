// SPDX-FileCopyrightText: 2026 the evermap authors
// SPDX-License-Identifier: BSD-3-Clause
#include <algorithm>
#include <cmath>
#include <utility>

#include <evermap/bags/detail/scan_bag.hpp>
#include <evermap/files/file_error.hpp>
#include <evermap/io/detail/scan_folder.hpp>

namespace evermap {
namespace {

/// Names in a list, for a message.
std::string list_of(const std::vector<std::string>& names) {
  std::string list;
  for (const std::string& name : names) list += (list.empty() ? "" : ", ") + name;
  return list;
}

std::optional<std::size_t> find_pose_topic(const BagReader& bag, const std::string& name) {
  for (std::size_t i = 0; i < bag.topics().size(); ++i) {
    if (bag.topics()[i].name == name && kind_of(bag.topics()[i].type) == MessageKind::kPoses) return i;
  }
  return std::nullopt;
}

/// The topic of this name, or the only one when it is empty.
std::optional<std::size_t> find_imu_topic(const BagReader& bag, const std::string& wanted) {
  std::vector<std::string> names;
  std::optional<std::size_t> found;
  for (std::size_t i = 0; i < bag.topics().size(); ++i) {
    const BagTopic& topic = bag.topics()[i];
    if (kind_of(topic.type) != MessageKind::kImu) continue;
    if (topic.name == wanted) return i;
    names.push_back(topic.name);
    found = i;
  }
  if (!wanted.empty())
    throw FileError(bag.path(), "has no sensor_msgs/Imu on " + wanted + "; it has " + list_of(names));
  return names.size() == 1 ? found : std::nullopt;
}

bool has_transforms(const BagReader& bag) {
  return std::any_of(bag.topics().begin(), bag.topics().end(),
                     [](const BagTopic& topic) { return kind_of(topic.type) == MessageKind::kTransforms; });
}

}  // namespace

std::size_t find_cloud_topic(const BagReader& bag, const std::string& wanted) {
  std::vector<std::string> names;
  std::size_t found = 0;
  for (std::size_t i = 0; i < bag.topics().size(); ++i) {
    const BagTopic& topic = bag.topics()[i];
    if (!is_cloud(topic) || (wanted.empty() && topic.messages == 0)) continue;
    if (topic.name == wanted) return i;
    names.push_back(topic.name);
    found = i;
  }
  if (names.empty()) {
    throw FileError(bag.path(),
                    "has no topic of point clouds (sensor_msgs/PointCloud2 or Livox's CustomMsg); evermap "
                    "info lists what it has");
  }
  if (!wanted.empty())
    throw FileError(bag.path(), "has no clouds on " + wanted + "; it has " + list_of(names));
  if (names.size() > 1)
    throw FileError(bag.path(), "has clouds on " + list_of(names) + "; choose one by --topic");
  return found;
}

ScanBag::ScanBag(const std::filesystem::path& path, const ScanOptions& options)
    : bag_(open_bag(path)),
      topic_(find_cloud_topic(*bag_, options.topic)),
      base_(options.base),
      reference_topic_(find_pose_topic(*bag_, options.reference)),
      mount_(options.mount),
      imu_topic_(options.is_imu_wanted ? find_imu_topic(*bag_, options.imu) : std::nullopt) {
  const bool is_wanted = options.is_reference_needed || has_transforms(*bag_);
  if (!reference_topic_ && is_wanted) reference_frame_ = options.reference;
  if (!reference_frame_.empty() && !has_transforms(*bag_)) {
    throw FileError(path, "has neither a topic of poses named " + options.reference +
                              " nor a /tf that could know such a frame; evermap info lists what it has");
  }
  if (mount_ && !reference_topic_) {
    throw FileError(path,
                    "its /tf tells where the sensor is; an extrinsic is for a file or a topic of poses");
  }
  std::vector<bool> selected(bag_->topics().size());
  for (std::size_t i = 0; i < selected.size(); ++i) {
    const bool is_transform = kind_of(bag_->topics()[i].type) == MessageKind::kTransforms;
    selected[i] = i == topic_ || i == reference_topic_ || i == imu_topic_ ||
                  (is_transform && !(options.reference.empty() && base_.empty() && !imu_topic_));
  }
  bag_->select(std::move(selected));
}

std::string ScanBag::place() const {
  return bag_->path().string() + ", cloud " + std::to_string(count_) + " of " + bag_->topics()[topic_].name;
}

std::optional<Scan> ScanBag::next() {
  while (waiting_.empty() || !is_due(waiting_.front())) {
    if (!read_message()) break;
  }
  if (waiting_.empty()) {
    // Once: who takes damage for that of one scan asks for the next.
    const bool is_news = count_ == 0 && !bag_->damage().empty() && !std::exchange(is_end_told_, true);
    if (is_news) throw FileError(bag_->path(), bag_->damage());
    return std::nullopt;
  }
  now_ = std::move(waiting_.front().message);
  waiting_.pop_front();
  ++count_;
  end_ = *now_.scan.time;
  return std::exchange(now_.scan, {});
}

bool ScanBag::read_message() {
  const std::optional<BagMessage> message = bag_->next();
  if (!message) return false;
  recorded_ = std::max(recorded_, message->time);
  const BagTopic& topic = bag_->topics()[message->topic];
  if (message->topic == topic_) {
    waiting_.push_back({read_cloud_message(topic, message->bytes, bag_->path()), message->time});
    return true;
  }
  if (message->topic == imu_topic_) {
    if (const std::optional<TurnRate> rate = read_turn_rate(topic, message->bytes)) gyroscope_.add(*rate);
    return true;
  }
  for (const StampedTransform& transform : read_transforms(topic, message->bytes)) {
    if (message->topic != reference_topic_) {
      transforms_.add(transform, topic.name.ends_with("tf_static"));
    } else {
      reference_.add(transform.time, transform.T_parent_child);
      child_ = transform.child;
    }
  }
  return true;
}

/// Whether its pose and rotation are known, or nothing that comes would tell them.
bool ScanBag::is_due(const Cloud& cloud) const {
  constexpr double kPatience = 2;  // [s] that poses may be recorded later than the cloud
  if (recorded_ > cloud.recorded + kPatience) return true;
  const double time = *cloud.message.scan.time;
  const bool has_pose =
      (!reference_topic_ && reference_frame_.empty()) || pose_of(cloud.message, time).has_value();
  return has_pose && (!imu_topic_ || gyroscope_.reaches(time));
}

std::optional<Pose> ScanBag::pose_at(double time) const { return pose_of(now_, time); }

std::optional<Eigen::Matrix3d> ScanBag::rotation_at(double time) const {
  return gyroscope_.rotation_of(now_.frame, transforms_, time);
}

std::optional<Pose> ScanBag::base_pose() const {
  return base_.empty() ? std::nullopt : transforms_.lookup(now_.frame, base_, end_);
}

std::optional<Pose> ScanBag::pose_of(const CloudMessage& cloud, double time) const {
  if (!reference_frame_.empty()) return transforms_.lookup(reference_frame_, cloud.frame, time);
  std::optional<Pose> T_reference_child = reference_.at(time);
  if (T_reference_child && mount_) return mount_->sensor_of(*T_reference_child);
  if (!T_reference_child || child_.empty() || child_ == cloud.frame) return T_reference_child;
  // A recording without transforms of the sensor: its poses are taken for the sensor's own.
  return *T_reference_child * transforms_.lookup(child_, cloud.frame, time).value_or(Pose{});
}

std::vector<std::string> ScanBag::remarks() const {
  std::vector<std::string> remarks;
  if (!bag_->damage().empty()) {
    remarks.push_back(bag_->damage() + "; what comes before, " + std::to_string(count_) + " of " +
                      std::to_string(size()) + " clouds, was read");
  }
  constexpr double kSameClock = 60;  // [s]
  if (!gyroscope_.empty() && std::abs(gyroscope_.last_time() - end_) > kSameClock) {
    remarks.push_back("the gyroscope's clock (" + std::to_string(gyroscope_.last_time()) +
                      " s) is not that of the clouds (" + std::to_string(end_) + " s); it was not used");
  } else if (!gyroscope_.empty() && gyroscope_.frame() != now_.frame &&
             !transforms_.connects(gyroscope_.frame(), now_.frame)) {
    remarks.push_back("/tf does not say how the gyroscope (" + gyroscope_.frame() +
                      ") is mounted on the sensor (" + now_.frame + "); it was not used");
  }
  if (!mount_ && !child_.empty() && child_ != now_.frame && !transforms_.connects(child_, now_.frame)) {
    remarks.push_back("/tf does not say where the sensor (" + now_.frame + ") is on " + child_ +
                      ", whose poses " + bag_->topics()[*reference_topic_].name +
                      " tells; they were taken for the sensor's");
  }
  return remarks;
}

std::unique_ptr<ScanSource> open_scans(const std::filesystem::path& path, const ScanOptions& options) {
  std::unique_ptr<ScanSource> scans;
  if (is_bag(path)) {
    scans = std::make_unique<ScanBag>(path, options);
  } else {
    scans = std::make_unique<ScanFolder>(path, options.cloud);
  }
  return std::make_unique<SelectedScans>(std::move(scans), options.selection);
}

}  // namespace evermap
