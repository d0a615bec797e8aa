// SPDX-FileCopyrightText: 2026 the evermap authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "experiments/contest.hpp"
#include "experiments/story.hpp"
#include "plot.hpp"

namespace evermap {

inline constexpr const char* kOctoMap = "OctoMap";
inline constexpr const char* kEvermap = "evermap default";

/// Contests' results as tables, curves and pictures.

/// SA .. AHD of each contender at the end of a contest; a contender that is not installed gets a row that
/// says so.
HtmlTable quality_table(const Json& result, const std::string& caption);

/// How a contest is told.
struct Telling {
  struct Curve {
    std::string measure;
    std::string title;
    bool is_distance = false;  ///< [m], else a share
  };
  std::vector<Curve> curves;          ///< panels of the figure
  std::string figure;                 ///< what it shows
  std::string view;                   ///< what the view from above shows
  std::vector<ShadedRange> shaded{};  ///< of the scans
};

/// Draws a contest's figures to files that begin with `stem`, and adds them and its tables. `data` says what
/// the contest was about.
void tell_contest(Story& story, const std::filesystem::path& folder, const std::string& stem,
                  const std::string& data, const Json& result, const Telling& telling);

/// A measure of a contender, along the run and at its end.
std::vector<double> along(const Json& result, const std::string& contender, const std::string& measure);
double at_end(const Json& result, const std::string& contender, const std::string& measure);

void aim_at_least(Story& story, const std::string& where, const std::string& what, double aimed,
                  double reached);
void aim_at_most(Story& story, const std::string& where, const std::string& what, double aimed,
                 double reached);
/// Whether evermap's measure at the end is the best of all contenders.
bool is_best(const Json& result, const std::string& measure, bool highest);
/// How far a curve falls below what it had reached before.
double largest_sag(const std::vector<double>& values);

}  // namespace evermap
