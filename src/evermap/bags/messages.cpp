// SPDX-FileCopyrightText: 2026 the evermap authors
// SPDX-License-Identifier: BSD-3-Clause
#include <algorithm>
#include <array>
#include <cmath>
#include <utility>

#include <evermap/bags/detail/messages.hpp>
#include <evermap/files/file_error.hpp>
#include <evermap/io/detail/scan_builder.hpp>

namespace evermap {
namespace {

struct Type {
  std::string_view name;
  MessageKind kind;
};
constexpr std::array<Type, 11> kTypes = {{
    {"sensor_msgs/PointCloud2", MessageKind::kCloud},
    {"livox_ros_driver/CustomMsg", MessageKind::kLivoxCloud},
    {"livox_ros_driver2/CustomMsg", MessageKind::kLivoxCloud},
    {"tf2_msgs/TFMessage", MessageKind::kTransforms},
    {"tf/tfMessage", MessageKind::kTransforms},
    {"nav_msgs/Odometry", MessageKind::kPoses},
    {"nav_msgs/Path", MessageKind::kPoses},
    {"geometry_msgs/PoseStamped", MessageKind::kPoses},
    {"geometry_msgs/PoseWithCovarianceStamped", MessageKind::kPoses},
    {"geometry_msgs/TransformStamped", MessageKind::kPoses},
    {"sensor_msgs/Imu", MessageKind::kImu},
}};

struct Header {
  double time;  ///< [s]
  std::string frame;
};

std::string frame_of(std::string_view name) {
  if (name.starts_with('/')) name.remove_prefix(1);  // of tf before tf2
  return std::string(name);
}

Header read_header(WireReader& message) {
  if (message.wire() == Wire::kRos1) message.skip(1, 4);  // its number
  const double time = message.stamp();
  return {time, frame_of(message.text())};
}

[[noreturn]] void fail(const std::filesystem::path& bag, const BagTopic& topic, const std::string& message) {
  throw FileError(bag, "a message of " + topic.name + " " + message);
}

/// PointCloud2's fields.
struct CloudLayout {
  Header header;
  std::uint32_t height = 0, width = 0;
  struct Entry {
    std::string name;
    std::uint32_t offset;  ///< [bytes]
    Scalar type;
    std::uint32_t count;
  };
  std::vector<Entry> fields = {};
};

CloudLayout read_cloud_layout(WireReader& message) {
  constexpr std::array<Scalar, 8> kDatatypes = {Scalar::kInt8,    Scalar::kUint8,  Scalar::kInt16,
                                                Scalar::kUint16,  Scalar::kInt32,  Scalar::kUint32,
                                                Scalar::kFloat32, Scalar::kFloat64};
  constexpr std::size_t kLeastField = 4 + 4 + 1 + 4;  // [bytes]
  CloudLayout layout{.header = read_header(message)};
  layout.height = message.number<std::uint32_t>();
  layout.width = message.number<std::uint32_t>();
  for (auto left = message.count(kLeastField); left > 0; --left) {
    std::string name(message.text());
    const auto offset = message.number<std::uint32_t>();
    const auto datatype = message.number<std::uint8_t>();
    const auto count = message.number<std::uint32_t>();
    if (datatype == 0 || datatype > kDatatypes.size()) continue;  // none that anyone here could use
    layout.fields.push_back({std::move(name), offset, kDatatypes[datatype - 1], std::max(count, 1U)});
  }
  return layout;
}

/// The fields in the order of their bytes, with what lies between them as "_"; none when a point is too
/// large. A field that overlaps one before is left out.
std::optional<RecordLayout> record_layout_of(CloudLayout& cloud, std::uint32_t point_step) {
  std::stable_sort(cloud.fields.begin(), cloud.fields.end(),
                   [](const auto& a, const auto& b) { return a.offset < b.offset; });
  RecordLayout layout;
  for (const CloudLayout::Entry& field : cloud.fields) {
    const std::uint64_t end = field.offset + std::uint64_t{field.count} * size_of(field.type);
    if (field.offset < layout.stride() || end > point_step) continue;
    const std::size_t gap = field.offset - layout.stride();
    if (gap > 0 && !layout.append("_", Scalar::kUint8, gap)) return std::nullopt;
    if (!layout.append(field.name, field.type, field.count)) return std::nullopt;
  }
  const std::size_t rest = point_step - layout.stride();
  if (rest > 0 && !layout.append("_", Scalar::kUint8, rest)) return std::nullopt;
  return layout;
}

/// [s] When the last point was taken.
double end_of(double stamp, const std::optional<PointTime>& points) {
  constexpr double kNear = 1;  // [s] what a sweep takes and a clock is off by
  if (!points) return stamp;
  if (std::abs(points->first) < kNear) return stamp + points->first + points->span;  // counted from the stamp
  if (std::abs(points->first - stamp) < kNear) return points->first + points->span;  // the same clock
  return stamp + points->span;  // another clock; most drivers stamp the beginning
}

CloudMessage finish(ScanBuilder& builder, Header header) {
  CloudMessage cloud;
  cloud.scan = builder.finish(&cloud.notes);
  cloud.scan.time = end_of(header.time, cloud.notes.time);
  cloud.frame = std::move(header.frame);
  return cloud;
}

CloudMessage read_point_cloud(const BagTopic& topic, std::string_view bytes,
                              const std::filesystem::path& bag) {
  WireReader message(bytes, topic.wire);
  CloudLayout cloud = read_cloud_layout(message);
  const bool is_big_endian = message.number<std::uint8_t>() != 0;
  const auto point_step = message.number<std::uint32_t>();
  std::uint64_t row_step = message.number<std::uint32_t>();
  const std::string_view data = message.take(message.number<std::uint32_t>());
  if (!message.is_good())
    fail(bag, topic, "is damaged; record it again, or leave it out by --start and --duration");
  if (point_step == 0) fail(bag, topic, "has points of 0 bytes");
  const std::uint64_t row_size = std::uint64_t{cloud.width} * point_step;
  if (row_step < row_size) row_step = row_size;  // some drivers leave it 0
  const std::uint64_t needed = cloud.height == 0 ? 0 : (cloud.height - 1) * row_step + row_size;
  if (needed > data.size()) {
    fail(bag, topic,
         "has " + std::to_string(data.size()) + " bytes of points where its sizes say " +
             std::to_string(needed));
  }
  const std::optional<RecordLayout> layout = record_layout_of(cloud, point_step);
  if (!layout) fail(bag, topic, "has points of " + std::to_string(point_step) + " bytes");
  ScanBuilder builder(bag, *layout);
  const std::uint64_t rows = cloud.width == 0 ? 0 : cloud.height;
  for (std::uint64_t row = 0; row < rows; ++row) {
    builder.add_records(data.substr(row * row_step, row_size), 0, cloud.width,
                        is_big_endian ? std::endian::big : std::endian::little);
  }
  return finish(builder, std::move(cloud.header));
}

CloudMessage read_livox_cloud(const BagTopic& topic, std::string_view bytes,
                              const std::filesystem::path& bag) {
  RecordLayout layout;
  bool fits = layout.append("offset_time", Scalar::kUint32, 1);
  for (const char* axis : {"x", "y", "z"}) fits = fits && layout.append(axis, Scalar::kFloat32, 1);
  for (const char* other : {"reflectivity", "tag", "line"})
    fits = fits && layout.append(other, Scalar::kUint8, 1);
  const std::size_t point_size = layout.stride();
  WireReader message(bytes, topic.wire);
  Header header = read_header(message);
  message.skip(1, 8);      // the time from which points count, which the stamp says, too
  message.skip(1, 4);      // number of points
  message.skip(1 + 3, 1);  // the sensor's number, and bytes in reserve
  const std::uint32_t points = message.count(point_size);
  std::string packed;
  packed.reserve(points * point_size);
  for (std::uint32_t i = 0; i < points; ++i) {
    message.skip(0, 4);  // in CDR each begins aligned
    packed += message.take(point_size);
  }
  if (!fits || !message.is_good())
    fail(bag, topic, "is damaged; record it again, or leave it out by --start and --duration");
  ScanBuilder builder(bag, layout);
  builder.add_records(packed, 0, points, message.order());
  return finish(builder, std::move(header));
}

}  // namespace

MessageKind kind_of(std::string_view type) {
  const auto* found =
      std::find_if(kTypes.begin(), kTypes.end(), [&](const Type& known) { return known.name == type; });
  return found == kTypes.end() ? MessageKind::kOther : found->kind;
}

CloudMessage read_cloud_message(const BagTopic& topic, std::string_view bytes,
                                const std::filesystem::path& bag) {
  return kind_of(topic.type) == MessageKind::kLivoxCloud ? read_livox_cloud(topic, bytes, bag)
                                                         : read_point_cloud(topic, bytes, bag);
}

CloudHead read_cloud_head(const BagTopic& topic, std::string_view bytes, const std::filesystem::path& bag) {
  WireReader message(bytes, topic.wire);
  CloudHead head;
  if (kind_of(topic.type) == MessageKind::kLivoxCloud) {
    head.frame = read_header(message).frame;
  } else {
    CloudLayout layout = read_cloud_layout(message);
    head = {std::move(layout.header.frame), layout.width, layout.height, {}};
    for (CloudLayout::Entry& field : layout.fields)
      head.fields.push_back({std::move(field.name), field.type});
  }
  if (!message.is_good()) fail(bag, topic, "is damaged");
  return head;
}

std::optional<TurnRate> read_turn_rate(const BagTopic& topic, std::string_view bytes) {
  constexpr std::size_t kQuaternion = 4;
  constexpr std::size_t kCovariance = 9;
  WireReader message(bytes, topic.wire);
  Header header = read_header(message);
  message.skip(kQuaternion + kCovariance, sizeof(double));
  TurnRate rate{header.time, std::move(header.frame), message.vector()};
  if (!message.is_good() || !rate.rate.allFinite()) return std::nullopt;
  return rate;
}

std::vector<StampedTransform> read_transforms(const BagTopic& topic, std::string_view bytes) {
  constexpr std::size_t kLeastPose = 56;  // [bytes]
  WireReader message(bytes, topic.wire);
  std::vector<StampedTransform> found;
  const auto read_one = [&](bool has_child) {
    Header header = read_header(message);
    std::string child = has_child ? frame_of(message.text()) : std::string();
    const Pose pose = message.pose();
    if (message.is_good()) found.push_back({header.time, std::move(header.frame), std::move(child), pose});
  };
  if (kind_of(topic.type) == MessageKind::kTransforms) {
    for (auto left = message.count(kLeastPose); left > 0; --left) read_one(true);
  } else if (topic.type == "nav_msgs/Path") {
    read_header(message);
    for (auto left = message.count(kLeastPose); left > 0; --left) read_one(false);
  } else {
    read_one(topic.type == "nav_msgs/Odometry" || topic.type == "geometry_msgs/TransformStamped");
  }
  return found;
}

}  // namespace evermap
