// SPDX-FileCopyrightText: 2026 the evermap authors
// SPDX-License-Identifier: BSD-3-Clause
// libFuzzer over one reader, EVERMAP_READ(path): whatever a file holds, it is read or refused by a FileError,
// and what was read can be written and read again.
#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>
#include <cstdlib>
#include <fstream>
#include <iterator>
#include <sstream>
#include <unistd.h>

#include <evermap/bags/detail/gyroscope.hpp>
#include <evermap/bags/detail/messages.hpp>
#include <evermap/bags/scan_bag.hpp>
#include <evermap/config/parameters_file.hpp>
#include <evermap/files/file_error.hpp>
#include <evermap/history/detail/packed_changes.hpp>
#include <evermap/history/map_history.hpp>
#include <evermap/history/map_store.hpp>
#include <evermap/io/cloud.hpp>
#include <evermap/io/map_file.hpp>
#include <evermap/io/poses.hpp>
#include <evermap/simulation/scenario.hpp>
#include <evermap/web/detail/door.hpp>
#include <evermap/web/map_page.hpp>

namespace {

[[maybe_unused]] void read_all(const std::filesystem::path& path) {
  const auto scans = evermap::open_scans(path, {.reference = "odom", .is_imu_wanted = true});
  while (const std::optional<evermap::Scan> scan = scans->next()) {
    scans->pose_at(*scan->time);
    scans->rotation_at(*scan->time);
  }
}

/// A message as it comes from the network; its first byte tells the type.
[[maybe_unused]] void read_message(const std::filesystem::path& path) {
  std::ostringstream content;
  content << std::ifstream(path, std::ios::binary).rdbuf();
  const std::string bytes = content.str();
  if (bytes.empty()) return;
  constexpr std::array<const char*, 6> kTypes = {"sensor_msgs/PointCloud2",
                                                 "livox_ros_driver2/CustomMsg",
                                                 "tf2_msgs/TFMessage",
                                                 "nav_msgs/Odometry",
                                                 "geometry_msgs/PoseWithCovarianceStamped",
                                                 "sensor_msgs/Imu"};
  const evermap::BagTopic topic{"/topic", kTypes[static_cast<unsigned char>(bytes[0]) % kTypes.size()],
                                evermap::Wire::kCdr};
  const std::string_view message = std::string_view(bytes).substr(1);
  evermap::TransformBuffer frames;
  evermap::Gyroscope gyroscope;
  if (evermap::is_cloud(topic)) {
    evermap::read_cloud_message(topic, message, "/topic");
  } else if (const auto rate = evermap::read_turn_rate(topic, message);
             evermap::kind_of(topic.type) == evermap::MessageKind::kImu) {
    if (rate) gyroscope.add(*rate);
  } else {
    for (const evermap::StampedTransform& transform : evermap::read_transforms(topic, message))
      frames.add(transform, false);
    frames.lookup("odom", "lidar", 0);
  }
}

[[maybe_unused]] void read_parameters(const std::filesystem::path& path) {
  evermap::Parameters parameters;
  evermap::read_parameters(path, parameters);
}

[[maybe_unused]] void read_history(const std::filesystem::path& path) {
  const evermap::MapHistory history(path.parent_path() / path.stem());
  for (const evermap::MapVersion& version : history.versions()) history.checkout(version.number);
}

/// A map with two versions, made once.
evermap::MapPage& page_of_a_map() {
  static const std::filesystem::path path =
      "/dev/shm/evermap-fuzz-page-" + std::to_string(::getpid()) + ".evm";
  static const bool is_made = [] {
    evermap::Octree map(evermap::VoxelGrid{.edge = 0.5});
    for (const int version : {1, 2}) {
      map.find_or_insert(evermap::VoxelKey::from_voxel({version, 2, 3})).log_odds = 1;
      evermap::MapStore(path).commit(map, {"version", ""});
    }
    return true;
  }();
  static evermap::MapPage page(path);
  static_cast<void>(is_made);
  return page;
}

/// Lines of method, path and query, then a body. Whatever is asked has one answer.
[[maybe_unused]] void ask_page(const std::filesystem::path& path) {
  std::ifstream file(path, std::ios::binary);
  evermap::WebRequest request;
  std::string query;
  std::getline(file, request.method);
  std::getline(file, request.path);
  std::getline(file, query);
  request.body.assign(std::istreambuf_iterator<char>(file), {});
  int answers = 0;
  page_of_a_map().respond(request, [&](const evermap::WebReply&) { ++answers; });
  if (answers != 1) std::abort();
  evermap::Door door("secretsecretsecret");
  const evermap::Door::Verdict verdict =
      door.judge({"9.9.9.9", request.method, request.path, request.body, request.body, query}, 0);
  const std::string all = request.body + query;
  if (verdict == evermap::Door::Verdict::kWelcome && all.find("secretsecretsecret") == std::string::npos)
    std::abort();
}

std::filesystem::path again(const std::filesystem::path& path) { return path.string() + ".again"; }

/// What is written of poses is rows of numbers, as many as there are poses.
[[maybe_unused]] void write_poses(const std::filesystem::path& path) {
  const std::vector<evermap::StampedPose> poses = evermap::read_poses(path).poses;
  if (!poses.front().time) return;
  evermap::write_tum_poses(again(path), poses);
  std::ostringstream text;
  text << std::ifstream(again(path)).rdbuf();
  const std::string rows = text.str();
  const auto count = static_cast<std::size_t>(std::count(rows.begin(), rows.end(), '\n'));
  if (count != poses.size() || rows.find_first_not_of("0123456789.+-e \n") != std::string::npos) std::abort();
}

/// A map that was written is read again as it was.
[[maybe_unused]] void write_map(const std::filesystem::path& path) {
  const evermap::Octree map = evermap::load_map(path);
  evermap::save_map(again(path), map);
  if (!(evermap::fingerprint_of(evermap::load_map(again(path))) == evermap::fingerprint_of(map)))
    std::abort();
}

/// A file in memory with the extension that the reader wants.
const std::filesystem::path& input_file() {
  static const std::filesystem::path path =
      "/dev/shm/evermap-fuzz-" + std::to_string(::getpid()) + EVERMAP_EXTENSION;
  return path;
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  std::ofstream(input_file(), std::ios::binary)
      .write(reinterpret_cast<const char*>(data), static_cast<std::streamsize>(size));
  try {
    EVERMAP_READ(input_file());
  } catch (const evermap::FileError&) {
  }
  return 0;
}
