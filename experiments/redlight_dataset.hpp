// SPDX-FileCopyrightText: 2026 the evermap authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <filesystem>

#include "experiments/dataset.hpp"

namespace evermap {

/// A real standstill (kitti_redlight_standstill, scans 55 to 76): the survey is up to date, traffic passes.
///
/// What stands still is told from the scans themselves: it is where it is in at least two of three stretches
/// of the run. All else within 40 m is traffic.
class RedlightDataset final : public Dataset {
 public:
  /// Throws FileError when the data cannot be read, std::runtime_error when there are too few scans.
  explicit RedlightDataset(const std::filesystem::path& folder);

  std::size_t number(std::size_t scan) const override { return kFirst + scan; }
  Points survey() const override { return surface_; }
  Truth truth(std::size_t scan) const override;
  Changes changes(double leaf) const override;

 private:
  static constexpr std::size_t kFirst = 55;  ///< scan, the car creeps before
  static constexpr std::size_t kScans = 22;

  Points surface_;  ///< [m] what stands still
};

}  // namespace evermap
