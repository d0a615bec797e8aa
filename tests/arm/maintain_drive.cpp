// SPDX-FileCopyrightText: 2026 the evermap authors
// SPDX-License-Identifier: BSD-3-Clause
// maintain_drive MAP DRIVE OUT: localizes the scans of a folder that `evermap simulate` wrote in the map MAP,
// without odometry, maintains it, and writes the map OUT.evm and the poses OUT.tum. Nothing beyond the core
// is needed.
#include <cstdio>
#include <exception>
#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include <evermap/io/detail/scan_folder.hpp>
#include <evermap/io/map_file.hpp>
#include <evermap/io/poses.hpp>
#include <evermap/maintenance/map_maintainer.hpp>

using namespace evermap;

namespace {

void maintain(const std::filesystem::path& survey, const std::filesystem::path& drive,
              const std::string& out) {
  const std::vector<StampedPose> truth = read_poses(drive / "poses.txt").poses;
  MapMaintainer maintainer(load_map(survey), {}, MapMode::kMaintenance, truth.at(0).T_map_sensor);
  ScanFolder scans(drive / "scans");
  std::vector<StampedPose> poses;
  std::size_t written = 0;
  while (const std::optional<Scan> scan = scans.next()) {
    const double time = truth.at(poses.size()).time.value();
    const ScanResult result = maintainer.process(*scan, time);
    poses.push_back({time, result.T_map_sensor});
    written += result.is_written;
  }
  save_map(out + ".evm", maintainer.map());
  write_tum_poses(out + ".tum", poses);
  std::printf("%zu scans, %zu written, %zu leaves\n", poses.size(), written, maintainer.map().leaf_count());
}

}  // namespace

int main(int argc, char** argv) {
  if (argc != 4) return 2;
  try {
    maintain(argv[1], argv[2], argv[3]);
    return 0;
  } catch (const std::exception& error) {
    std::fprintf(stderr, "%s\n", error.what());
    return 1;
  }
}
