// SPDX-FileCopyrightText: 2026 the evermap authors
// SPDX-License-Identifier: BSD-3-Clause
// write_seeds FOLDER: a small file of each kind for the fuzzers to begin with, in FOLDER/<fuzzer>.
#include <fstream>
#include <zlib.h>

#include "bags/bag_writer.hpp"
#include <evermap/config/parameters_file.hpp>
#include <evermap/geometry/pose.hpp>
#include <evermap/history/map_store.hpp>
#include <evermap/io/map_file.hpp>

namespace evermap {
namespace {

std::vector<WrittenMessage> messages_in(Wire wire) {
  constexpr double kTime = 1700000000;  // [s]
  std::vector<WrittenMessage> messages;
  messages.push_back({"/tf_static", "tf2_msgs/TFMessage", kTime,
                      transform_message(wire, kTime, "base_link", "lidar", Pose{})});
  for (int i = 0; i < 3; ++i) {
    const double time = kTime + 0.1 * i;
    messages.push_back({"/points", "sensor_msgs/PointCloud2", time,
                        cloud_message(wire, time, "lidar", {{1, 2, 3, 0}, {4, 5, 6, 0.1F}})});
    messages.push_back({"/imu", "sensor_msgs/Imu", time, imu_message(wire, time, "lidar", {0.1, 0.2, 0.3})});
    messages.push_back(
        {"/tf", "tf2_msgs/TFMessage", time, transform_message(wire, time, "odom", "base_link", Pose{})});
    messages.push_back(
        {"/odom", "nav_msgs/Odometry", time, odometry_message(wire, time, "odom", "base_link", Pose{})});
  }
  return messages;
}

void write_seeds(const std::filesystem::path& folder) {
  const auto write = [&](const std::string& fuzzer, const std::string& name, const std::string& bytes) {
    std::filesystem::create_directories(folder / fuzzer);
    std::ofstream(folder / fuzzer / name, std::ios::binary)
        .write(bytes.data(), static_cast<std::streamsize>(bytes.size()));
  };
  for (const char* fuzzer : {"gzip", "map", "history"}) std::filesystem::create_directories(folder / fuzzer);
  for (const std::string compression : {"none", "bz2", "lz4"})
    write("ros1_bag", compression, ros1_bag(messages_in(Wire::kRos1), {compression, true, 4}));
  for (const std::string compression : {"none", "lz4", "zstd"})
    write("mcap", compression, mcap_bag(messages_in(Wire::kCdr), Wire::kCdr, {compression, true, 4}));
  for (const WrittenMessage& message : messages_in(Wire::kCdr)) {
    const char type = message.topic == "/points" ? 0
                      : message.topic == "/odom" ? 3
                      : message.topic == "/imu"  ? 5
                                                 : 2;
    write("message", message.topic.substr(1), type + message.bytes);
  }
  std::filesystem::create_directories(folder / "sqlite_bag");
  write_sqlite_bag(folder / "sqlite_bag" / "none", messages_in(Wire::kCdr));
  const std::string floats = bytes_of<float>({1, 2, 3, 4, 5, 6, 7, 8});
  const std::string pcd =
      "VERSION 0.7\nFIELDS x y z t\nSIZE 4 4 4 4\nTYPE F F F F\nCOUNT 1 1 1 1\nWIDTH 2\nHEIGHT 1\n"
      "VIEWPOINT 0 0 0 1 0 0 0\nPOINTS 2\nDATA ";
  write("pcd", "binary", pcd + "binary\n" + floats);
  write("pcd", "ascii", pcd + "ascii\n1 2 3 4\n5 6 7 8\n");
  write("pcd", "compressed",
        pcd + "binary_compressed\n" + bytes_of<std::uint32_t>({33, 32}) + '\x1f' + floats);
  const std::string ply =
      "element vertex 2\nproperty float x\nproperty float y\nproperty float z\nproperty list uchar "
      "int v\nend_header\n";
  write("ply", "ascii", "ply\nformat ascii 1.0\n" + ply + "1 2 3 2 8 9\n1 2 3 0\n");
  write("ply", "binary",
        "ply\nformat binary_little_endian 1.0\n" + ply + bytes_of<float>({1, 2, 3}) + '\0' +
            bytes_of<float>({4, 5, 6}) + '\1' + bytes_of<std::int32_t>({7}));
  write("bin", "four", floats);
  write("text", "csv", "x,y,z\n1,2,3\n4,5,6\n");
  write("npy", "rows",
        std::string("\x93NUMPY\x01\x00\x40\x00", 10) +
            "{'descr': '<f4', 'fortran_order': False, 'shape': (2, 4), }    \n" + floats);
  write(
      "bt", "voxels",
      "# Octomap OcTree binary file\nid OcTree\nsize 3\nres 0.1\ndata\n" + std::string("\x03\0\x02\x40", 4));
  write("ot", "voxels",
        "# Octomap OcTree file\nid OcTree\nsize 2\nres 0.1\ndata\n" +
            std::string("\0\0\x80\x3F\x01\0\0\x80\x3F\0", 10));
  write("las", "empty", "LASF" + std::string(371, '\1'));
  gzFile compressed = gzopen((folder / "gzip" / "csv").c_str(), "wb");
  gzputs(compressed, "x,y,z\n1,2,3\n4,5,6\n");
  gzclose(compressed);
  Octree octree(VoxelGrid{.edge = 0.5});
  octree.find_or_insert(VoxelKey::from_voxel({1, 2, 3})).count = 4;
  save_map(folder / "map" / "leaf", octree);
  save_map(folder / "map" / "frame", Octree(octree.grid(), {"site", MapFrame::GeoPoint{48.1, 11.5, 520}}));
  write("calibration", "odometry", "P0: 7 0 6 0 0 7 2 0 0 0 1 0\nTr: 0 -1 0 0 0 0 -1 -0.1 1 0 0 -0.3\n");
  write("calibration", "raw", "calib_time: 15-Mar-2012\nR: 0 -1 0 0 0 -1 1 0 0\nT: 0 -0.1 -0.3\n");
  const std::filesystem::path map = folder / "history.evm";
  MapStore(map).create(octree, {"import", ""});
  octree.find_or_insert(VoxelKey::from_voxel({3, 2, 1})).count = 5;
  MapStore(map).commit(octree, {"update", ""});
  std::filesystem::rename(map.string() + ".history", folder / "history" / "versions");
  write("parameters", "all", to_yaml(Parameters{}));
  write("scenario", "yard",
        "scans: 2\nground:\n  area: [-30, -30, 30, 30]\n  features:\n    - slope: [0.02, 0.01]\nrobot:\n"
        "  sensor_height: 1.7\n  route:\n    speed: 4\n    waypoints: [{at: [-11, -8], speed: 5}, [3, -8]]\n"
        "objects:\n  - {name: box, box: [6, 2.4, 2.6], places: [[-15, 8, 11]], from: 1}\n");
  write("page", "tile", "GET\n/api/maps/1..now/tiles/2/0/0/0\ntoken=secretsecretsecret\n");
  write("page", "changes", "GET\n/api/maps/1..2/changes\n\n");
  write("page", "command", "POST\n/api/command\n\n{\"command\": \"save\"}");
  write("poses", "tum", "0 1 2 3 0 0 0 1\n1 2 3 4 0 0 0 1\n");
  write("poses", "kitti", "1 0 0 0 0 1 0 0 0 0 1 0\n");
}

}  // namespace
}  // namespace evermap

int main(int argc, char** argv) {
  if (argc != 2) return 2;
  evermap::write_seeds(argv[1]);
  return 0;
}
