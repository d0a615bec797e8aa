// SPDX-FileCopyrightText: 2026 the evermap authors
// SPDX-License-Identifier: BSD-3-Clause
#include <algorithm>
#include <array>
#include <cmath>
#include <iterator>
#include <set>
#include <unordered_map>

#include <evermap/map/detail/block_leaves.hpp>
#include <evermap/map/detail/leaf_changes.hpp>
#include <evermap/map/map_difference.hpp>
#include <evermap/ros/detail/idl_types.hpp>
#include <evermap/ros/detail/map_topics.hpp>

namespace evermap {
namespace {

/// A point of the map as it is sent.
struct MapPoint {
  float x, y, z;         ///< [m] the leaf's mean
  float probability;     ///< of occupancy
  std::int32_t tile[3];  ///< the block it lies in, counted from the map's grid origin
};

/// The points of a map's tiles as one message. Of a map whose message would be larger than DDS takes, one
/// leaf in so many.
class CloudOfTiles {
 public:
  explicit CloudOfTiles(const Octree& map) : one_in_(1 + map.leaf_count() / kMostLeaves) {}

  void add_tile(const Octree& map, std::uint64_t block_key) {
    const Eigen::Vector3i tile = VoxelKey::first_of_block(block_key).voxel() / VoxelKey::kBlockEdge;
    const std::size_t before = points_.size();
    for_each_leaf_of(map, block_key, [&](VoxelKey key, const Leaf& leaf) {
      if (leaf.occupied() && hash_bits(key.bits()) % one_in_ == 0)
        add_point(map.gaussian(key, leaf).mean, leaf.log_odds, tile);
    });
    // Nothing is left there: one point that is none tells which tile is empty.
    if (points_.size() == before) add_point(Eigen::Vector3d::Constant(std::nan("")), 0, tile);
  }

  bool empty() const { return points_.empty(); }

  void send_to(DdsWriter& writer, double time, const std::string& frame) const {
    send(writer, time, frame,
         {{"x"}, {"y"}, {"z"}, {"probability"}, {"tile_x", false}, {"tile_y", false}, {"tile_z", false}},
         {reinterpret_cast<const std::uint8_t*>(points_.data()), points_.size() * sizeof(MapPoint)});
  }

 private:
  void add_point(const Eigen::Vector3d& p_map, float log_odds, const Eigen::Vector3i& tile) {
    const Eigen::Vector3f p = p_map.cast<float>();
    points_.push_back({p.x(), p.y(), p.z(), 1 / (1 + std::exp(-log_odds)), {tile.x(), tile.y(), tile.z()}});
  }

  static constexpr std::size_t kMostLeaves = 8'000'000;  // 224 MB

  std::size_t one_in_;
  std::vector<MapPoint> points_;
};

}  // namespace

MapTopics::MapTopics(DdsNode& node, const std::string& name, std::string map_frame)
    : name_(name),
      map_frame_(std::move(map_frame)),
      transforms_(node, "/tf", tf2_msgs_msg_dds__TFMessage__desc, Delivery::kReliable),
      pose_(node, "/" + name + "/pose", geometry_msgs_msg_dds__PoseWithCovarianceStamped__desc,
            Delivery::kReliable),
      odometry_(node, "/" + name + "/odometry", nav_msgs_msg_dds__Odometry__desc, Delivery::kReliable),
      map_(node, "/" + name + "/map", sensor_msgs_msg_dds__PointCloud2__desc, Delivery::kLatched),
      updates_(node, "/" + name + "/map_updates", sensor_msgs_msg_dds__PointCloud2__desc,
               Delivery::kReliable),
      changes_(node, "/" + name + "/changes", visualization_msgs_msg_dds__MarkerArray__desc,
               Delivery::kReliable),
      diagnostics_(node, "/diagnostics", diagnostic_msgs_msg_dds__DiagnosticArray__desc, Delivery::kReliable),
      reply_(node, "/" + name + "/reply", std_msgs_msg_dds__String__desc, Delivery::kReliable) {}

void MapTopics::send_transform(double time, const std::string& child, const Pose& T_map_child) {
  const std::vector<StampedTransform> transforms = {{time, map_frame_, child, T_map_child}};
  send(transforms_, transforms);
}

void MapTopics::send_pose(const ScanResult& scan, const std::string& base, const Pose& T_sensor_base) {
  const StampedTransform pose = {scan.time, map_frame_, base, scan.T_map_sensor * T_sensor_base};
  const Eigen::Matrix<double, 6, 6> covariance = scan.covariance_of(T_sensor_base);
  const geometry_msgs_msg_dds__PoseWithCovarianceStamped_ stamped{
      header_of(scan.time, map_frame_), with_covariance(pose.T_parent_child, covariance)};
  pose_.write(&stamped);
  send(odometry_, pose, covariance);
}

void MapTopics::send_map(double time, const Octree& map) {
  CloudOfTiles cloud(map);
  for (const std::uint64_t block : map.block_keys()) cloud.add_tile(map, block);
  cloud.send_to(map_, time, map_frame_);
}

void MapTopics::send_updates(double time, const Octree& before, const Octree& after) {
  CloudOfTiles cloud(after);
  std::set<std::uint64_t> tiles;
  for (const LeafChange& change : changes_between(before, after)) tiles.insert(change.key.block());
  for (const std::uint64_t tile : tiles) cloud.add_tile(after, tile);
  if (!cloud.empty()) cloud.send_to(updates_, time, map_frame_);
}

void MapTopics::send_changes(double time, const std::vector<SurfaceChange>& changes) {
  constexpr std::int32_t kCube = 1;
  constexpr std::int32_t kLasting = 60;  // [s] as long as it is shown
  if (changes.empty()) return;
  std::string came = "came";
  std::string went = "went";
  std::vector<std::string> texts;
  texts.reserve(changes.size());
  std::vector<visualization_msgs_msg_dds__Marker_> markers;
  markers.reserve(changes.size());
  for (const SurfaceChange& change : changes) {
    const Eigen::Vector3d center = change.box.center();
    const Eigen::Vector3d size = change.box.sizes();
    texts.push_back((change.has_come ? came : went) + ", " + std::to_string(change.leaves) +
                    " leaves, box of " + std::to_string(size.prod()) + " m3");
    visualization_msgs_msg_dds__Marker_ marker{};
    marker.header = header_of(time, map_frame_);
    marker.ns = text(change.has_come ? came : went);
    marker.id = change_id_++;
    marker.type = kCube;
    marker.pose = pose_of({Eigen::Matrix3d::Identity(), center});
    marker.scale = {size.x(), size.y(), size.z()};
    // Blue and orange: told apart by everybody.
    if (change.has_come) {
      marker.color = {0.0F, 0.45F, 0.7F, 0.5F};
    } else {
      marker.color = {0.9F, 0.6F, 0.0F, 0.5F};
    }
    marker.lifetime.sec = kLasting;
    marker.text = text(texts.back());
    for (char** unused : {&marker.texture_resource, &marker.texture.header.frame_id, &marker.texture.format,
                          &marker.mesh_resource, &marker.mesh_file.filename})
      *unused = text(empty_);
    markers.push_back(marker);
  }
  visualization_msgs_msg_dds__MarkerArray_ message{};
  message.markers = view_of<decltype(message.markers)>(markers);
  changes_.write(&message);
}

void MapTopics::send_diagnosis(double time, const Diagnosis& diagnosis) {
  std::vector<diagnostic_msgs_msg_dds__KeyValue_> values;
  values.reserve(diagnosis.values.size());
  for (const auto& [key, value] : diagnosis.values) values.push_back({text(key), text(value)});
  std::string title = name_ + ": localization and map";
  std::vector<diagnostic_msgs_msg_dds__DiagnosticStatus_> status(1);
  status[0].level = static_cast<std::uint8_t>(diagnosis.level);
  status[0].name = text(title);
  status[0].message = text(diagnosis.message);
  status[0].hardware_id = text(empty_);
  status[0].values = view_of<decltype(status[0].values)>(values);
  diagnostic_msgs_msg_dds__DiagnosticArray_ message{};
  message.header = header_of(time, empty_);
  message.status = view_of<decltype(message.status)>(status);
  diagnostics_.write(&message);
}

void MapTopics::send_reply(const std::string& reply) {
  std_msgs_msg_dds__String_ message{text(reply)};
  reply_.write(&message);
}

}  // namespace evermap
