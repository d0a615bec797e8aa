// SPDX-FileCopyrightText: 2026 the evermap authors
// SPDX-License-Identifier: BSD-3-Clause
// maintain_drive DRIVE OUT: localizes the scans of a folder written by `evermap simulate` in the map that
// they make, without odometry, and writes the map OUT.evm and the poses OUT.tum. Nothing beyond the core is
// needed.
#include <cstdio>
#include <exception>
#include <filesystem>
#include <string>
#include <vector>

#include <evermap/io/map_file.hpp>
#include <evermap/io/poses.hpp>
#include <evermap/io/scan_source.hpp>
#include <evermap/localization/detail/localizer.hpp>
#include <evermap/scan/detail/deskew.hpp>
#include <evermap/update/detail/map_updater.hpp>

using namespace evermap;

namespace {

void maintain(const std::filesystem::path& drive, const std::string& out) {
  constexpr double kDuration = 0.1;  // [s] of a scan
  const std::vector<StampedPose> truth = read_poses(drive / "poses.txt");
  ScanSource scans(drive / "scans");
  const UpdateParameters parameters;
  Octree map(VoxelGrid::around(truth.at(0).T_map_sensor.translation, 0.2));
  Localizer localizer(truth[0].T_map_sensor, {});
  std::vector<StampedPose> poses;
  while (const std::optional<Scan> raw = scans.next()) {
    const double time = truth.at(poses.size()).time.value();
    const Scan scan = deskew(*raw, localizer.motion(time, std::nullopt, kDuration), kDuration);
    if (map.empty()) {
      add_scan(map, scan, truth[0].T_map_sensor, parameters);
      poses.push_back(truth[0]);
      continue;
    }
    const Localization at = localizer.localize(map, scan, time, std::nullopt, [&](const Pose& T_map_sensor) {
      update(map, scan, T_map_sensor, parameters);
      return std::string();
    });
    poses.push_back({time, at.T_map_sensor});
  }
  save_map(out + ".evm", map);
  write_tum_poses(out + ".tum", poses);
  std::printf("%zu scans, %zu leaves, %s\n", poses.size(), map.leaf_count(),
              std::string(to_string(localizer.state())).c_str());
}

}  // namespace

int main(int argc, char** argv) {
  if (argc != 3) return 2;
  try {
    maintain(argv[1], argv[2]);
    return 0;
  } catch (const std::exception& error) {
    std::fprintf(stderr, "%s\n", error.what());
    return 1;
  }
}
