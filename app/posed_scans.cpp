// SPDX-FileCopyrightText: 2026 the evermap authors
// SPDX-License-Identifier: BSD-3-Clause
#include "posed_scans.hpp"

#include <string>
#include <utility>

#include <evermap/files/file_error.hpp>

namespace evermap {

PosedScans::PosedScans(const std::filesystem::path& scans, const std::filesystem::path& poses,
                       const CloudOptions& cloud)
    : scans_(scans, cloud), poses_(read_poses(poses)) {
  if (poses_.size() == scans_.size()) return;
  throw FileError(poses, "has " + std::to_string(poses_.size()) + " poses for the " +
                             std::to_string(scans_.size()) + " scans of " + scans.string() +
                             "; give one pose for each scan");
}

std::optional<PosedScan> PosedScans::next() {
  std::optional<Scan> scan = scans_.next();
  if (!scan) return std::nullopt;
  const std::size_t index = position_++;
  return PosedScan{std::move(*scan), poses_[index].T_map_sensor, scans_.file(index)};
}

}  // namespace evermap
