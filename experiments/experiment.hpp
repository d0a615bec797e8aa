// SPDX-FileCopyrightText: 2026 the evermap authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <filesystem>
#include <functional>
#include <string>
#include <vector>

#include "experiments/comparison.hpp"

namespace evermap {

/// Folders of the real drives.
inline constexpr const char* kDrive = "kitti_0005_drive";
inline constexpr const char* kRedlight = "kitti_redlight_standstill";

/// How experiments are to be run.
struct Setup {
  std::filesystem::path data;  ///< folder of the real drives; empty or absent: they are left out
  bool is_quick = false;
  std::uint64_t seed = 1;        ///< of the simulated sensor's noise
  int seeds = 3;                 ///< how many the robustness is measured with
  std::vector<double> leaves{};  ///< [m] empty: each experiment's own
};

/// A part of an experiment that is computed in one go and kept.
struct Unit {
  std::string name;   ///< also of the file that it is kept in
  std::string title;  ///< in tables
  Json settings;      ///< all that its result depends on, besides the program
  std::function<Json(const Progress&)> compute;
  bool is_timed = false;  ///< its result is a time, which must not depend on what else is at work
};

struct Experiment {
  std::string name;  ///< as on the command line
  std::vector<Unit> units{};
  std::vector<std::string> left_out{};  ///< parts that cannot be run, and why
};

Experiment experiment_a(const Setup& setup);
Experiment experiment_b(const Setup& setup);
Experiment experiment_c(const Setup& setup);
Experiment experiment_localization(const Setup& setup);
Experiment experiment_timing(const Setup& setup);
Experiment experiment_ablation(const Setup& setup);
Experiment experiment_robustness(const Setup& setup);
Experiment experiment_arena(const Setup& setup);
Experiment experiment_worlds(const Setup& setup);
Experiment experiment_year(const Setup& setup);

/// [m] The setup's leaf edges, or those of most experiments.
std::vector<double> leaves_of(const Setup& setup);

/// Of a real drive: empty when its folder is there, else why it is left out.
std::string why_left_out(const Setup& setup, const std::string& folder);

}  // namespace evermap
