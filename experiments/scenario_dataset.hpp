// SPDX-FileCopyrightText: 2026 the evermap authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <memory>
#include <optional>
#include <string>
#include <unordered_set>
#include <vector>

#include "experiments/dataset.hpp"
#include <evermap/simulation/scenario_drive.hpp>

namespace evermap {

/// Which scans of a scenario are driven, and how finely its surface is sampled. The truth's spacing should be
/// no simple fraction of a leaf: samples would all lie equally far from the leaves' middles.
struct ScenarioChoice {
  std::string scenario{};         ///< one that comes with evermap, unless another is given
  std::size_t every = 1;          ///< each so many scans one is used
  std::optional<int> scans{};     ///< of the scenario, from the first; none: all
  double survey_spacing = 0.1;    ///< [m]
  double truth_spacing = 0.17;    ///< [m]
  Eigen::AlignedBox2d area{};     ///< [m] that is measured; empty: all of the ground
  Eigen::AlignedBox2d view{};     ///< [m] that pictures show; empty: what is measured
  bool stands_at_middle = false;  ///< the robot stays where it would be half way through
};

/// A simulated run. Its truth is exact: what moves is left out, what grows is as it is at that scan.
class ScenarioDataset final : public Dataset {
 public:
  /// Simulates all scans, in parallel in the caller's TBB arena. `seed`: of the sensor's noise.
  ScenarioDataset(const ScenarioChoice& choice, std::uint64_t seed);
  ScenarioDataset(Scenario scenario, ScenarioChoice choice);

  std::size_t number(std::size_t scan) const override { return scan * choice_.every; }
  Points survey() const override { return drive_.survey(choice_.survey_spacing); }
  Truth truth(std::size_t scan) const override;
  Changes changes(double leaf) const override;

  /// True samples [m] of objects whose name begins with `prefix`, as they are at the last scan, where the
  /// scans of the last `scans` of the scenario observed them.
  Points observed_lately(const std::string& prefix, std::size_t scans) const;

 private:
  using Voxels = std::unordered_set<std::uint64_t>;

  Voxels observed_by(std::size_t first_scan) const;
  void find_dynamic_objects(std::vector<LabelledScan> labelled);

  ScenarioChoice choice_;
  ScenarioDrive drive_;
  Voxels observed_;
};

}  // namespace evermap
