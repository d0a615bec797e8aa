// SPDX-FileCopyrightText: 2026 the evermap authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstddef>
#include <filesystem>
#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "experiments/experiment.hpp"

namespace evermap {

/// A folder of experiments. What has been computed is kept there and not computed again, so that a run that
/// was interrupted goes on where it was.
class ResultCache {
 public:
  /// Keeps what another build of the program has computed when `any_build`.
  /// Throws FileError when the folder holds what no experiment has written, or cannot be written.
  ResultCache(std::filesystem::path folder, bool any_build);

  /// Told that a unit begins (nothing is done) and goes on; by several threads, but one at a time.
  using Watch = std::function<void(std::size_t unit, std::size_t done, std::size_t total)>;

  /// Computes the units side by side, and then, one by one, those that are timed. Throws what one of them
  /// throws; the others that were at work are kept.
  void compute(const std::vector<Unit>& units, const Watch& watch) const;
  /// The result of a unit, computed when it is not there.
  Json result(const Unit& unit, const Progress& progress) const;
  /// The result of a unit, if it is there.
  std::optional<Json> stored(const Unit& unit) const;

 private:
  std::filesystem::path file_of(const Unit& unit) const;

  std::filesystem::path folder_;
  bool any_build_;
};

}  // namespace evermap
