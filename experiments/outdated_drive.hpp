// SPDX-FileCopyrightText: 2026 the evermap authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <filesystem>
#include <vector>

#include "experiments/dataset.hpp"

namespace evermap {

/// A real drive (kitti_0005_drive) with a survey made outdated by construction, so that the truth is known.
///
/// The survey is what the scans show of what does not move, except that the parked vehicles are missing (they
/// have come since), six copies of them stand where the ground is free (they have gone), what stands in a
/// square of 3 m beside the road is 0.3 m off, and a strip of ground of 10 m is 0.3 m too high.
class OutdatedDrive final : public Dataset {
 public:
  /// Uses the first `scans` scans. Throws FileError when the data cannot be read, std::runtime_error when the
  /// changes find no room in them.
  OutdatedDrive(const std::filesystem::path& folder, std::size_t scans);

  std::size_t number(std::size_t scan) const override { return scan; }
  Points survey() const override { return survey_; }
  Truth truth(std::size_t scan) const override;
  Changes changes(double leaf) const override;

 private:
  Points surface_;    ///< [m] all that does not move
  Points confirmed_;  ///< [m] of it, what several scans show
  Points survey_;     ///< [m]
};

}  // namespace evermap
