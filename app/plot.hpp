// SPDX-FileCopyrightText: 2026 the evermap authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstddef>
#include <filesystem>
#include <optional>
#include <string>
#include <vector>

namespace evermap {

struct Axis {
  std::string label;  ///< with its unit, as in "time [s]"
  bool is_logarithmic = false;
  std::optional<double> low{}, high{};  ///< the range; what is not given follows from the data
  std::vector<double> tics{};           ///< marked places; empty: chosen by the range
};

/// One line of a plot, or one colour of its bars. A NaN in `y` leaves a gap.
struct Series {
  /// How the interval from `low` to `high` is drawn: as bars at the points, or as a band along the line.
  enum class Spread { kBars, kBand };

  std::string name;                   ///< in the legend; none when empty
  std::vector<double> x{};            ///< empty in a plot of groups
  std::vector<double> y;              ///< one of each x, or of each group
  std::vector<double> low{}, high{};  ///< of each y; empty: no interval is drawn
  Spread spread = Spread::kBars;
  /// Colour, dashes and marker; by default the series' place in the plot.
  std::optional<std::size_t> style{};
};

/// A stretch of the x axis with a grey ground.
struct ShadedRange {
  double from, to;
  std::string label;  ///< above the frame
};

/// Lines over x; or bars in groups, when `groups` are named.
struct Plot {
  std::string title;
  Axis x, y;
  std::vector<Series> series;
  std::vector<ShadedRange> shaded;
  std::vector<std::string> groups;
};

/// Draws the panels side by side, with one legend below them, to `stem`.png and `stem`.svg; their data go to
/// `stem`.csv with the columns panel, series, x, y, low, high. Series of one style in several panels share
/// one entry of the legend. The same panels give the same bytes.
///
/// Colours are those of Okabe and Ito, told apart with any colour vision; dashes and markers differ as well.
///
/// Draws with gnuplot. Throws std::invalid_argument when a series' sizes differ or a panel has no finite
/// value, std::runtime_error when gnuplot is missing or fails, IoError when a file cannot be written.
void write_plot(const std::filesystem::path& stem, const std::vector<Plot>& panels);
void write_plot(const std::filesystem::path& stem, const Plot& plot);

}  // namespace evermap
