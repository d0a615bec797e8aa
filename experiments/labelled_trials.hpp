// SPDX-FileCopyrightText: 2026 the evermap authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <filesystem>
#include <vector>

#include "posed_scans.hpp"
#include <evermap/evaluation/labelled_drive.hpp>
#include <evermap/evaluation/map_metrics.hpp>
#include <evermap/scan/detail/labelled_box.hpp>
#include <evermap/update/parameters.hpp>

namespace evermap {

/// kitti_0005_drive: a map built of all scans, with the trails of all that moves, then updated over them.
class DriveTrial {
 public:
  DriveTrial(const std::filesystem::path& folder, std::size_t scans);

  DriveScore run(double edge, const UpdateParameters& update) const;

 private:
  std::vector<PosedScan> scans_;
  std::vector<std::vector<LabelledBox>> boxes_;
};

/// kitti_redlight_standstill: a map of scans 55 to 60, updated over 61 to 76 from one place.
class RedlightTrial {
 public:
  explicit RedlightTrial(const std::filesystem::path& folder);

  /// Fraction of the surface that is still there which the map keeps.
  double run(double edge, const UpdateParameters& update) const;

 private:
  static constexpr std::ptrdiff_t kBuilt = 6;
  static constexpr std::ptrdiff_t kUpdated = 16;

  std::vector<Scan> scans_;
  Points still_there_;
};

}  // namespace evermap
