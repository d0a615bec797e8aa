// SPDX-FileCopyrightText: 2026 the evermap authors
// SPDX-License-Identifier: BSD-3-Clause
#include "gnuplot_script.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <map>

#include <fmt/format.h>

namespace evermap {
namespace {

/// Colours of Okabe and Ito (2008), the darker ones first; yellow is left out, for it fades on white.
constexpr std::array<std::string_view, 7> kColors = {"#0072b2", "#d55e00", "#009e73", "#000000",
                                                     "#cc79a7", "#e69f00", "#56b4e9"};
constexpr std::array<std::string_view, 5> kDashes = {"1", "(12,4)", "(3,3)", "(12,4,2,4)", "(20,4)"};
/// gnuplot's point types: disc, square, triangle, diamond, triangle down, circle, open square.
constexpr std::array<int, 7> kMarkers = {7, 5, 9, 13, 11, 6, 4};
/// gnuplot's fill patterns, for bars: full, and hatchings that differ from their neighbours.
constexpr std::array<std::string_view, 4> kFills = {"solid 1.0", "pattern 4", "solid 0.45", "pattern 2"};

// All of a figure's lengths are pixels of a figure that a page shows about as large.
constexpr int kFontSize = 14;
constexpr int kLegendRow = 24;
constexpr int kSample = 48;  ///< of a line, in the legend
constexpr int kLine = 20;    ///< of text
constexpr int kLeft = 84, kRight = 26, kTop = 24, kBottom = 76;
constexpr int kHeight = 330;  ///< of a frame

constexpr std::size_t kMostMarkers = 14;  ///< of a line; one of more points shows them now and then
constexpr double kBarShare = 0.8;         ///< of the distance of groups that bars cover

struct LegendEntry {
  std::size_t style;
  std::string name;
  bool has_bar = false, has_line = false;
  int left = 0, row = 0;  ///< [pixels] of its sample, and the line from above
};

/// The legend is drawn by hand: gnuplot's terminals differ in the room that they give to its own.
struct Layout {
  std::vector<LegendEntry> legend;
  int frame_width, width, height, top, legend_height;
};

struct Wrapped {
  std::string text;  ///< an expression of gnuplot's
  int lines;
};

/// Breaks the text at blanks where a line would be wider than `width` [pixels].
Wrapped wrapped(std::string_view text, double width) {
  const auto columns = static_cast<std::size_t>(std::max(width / (0.55 * kFontSize), 1.0));
  Wrapped result{"", 1};
  while (text.size() > columns) {
    std::size_t blank = text.rfind(' ', columns);
    if (blank == std::string_view::npos) blank = text.find(' ');
    if (blank == std::string_view::npos) break;
    result.text += gnuplot_quoted(text.substr(0, blank)) + ".\"\\n\".";
    ++result.lines;
    text.remove_prefix(blank + 1);
  }
  result.text += gnuplot_quoted(text);
  return result;
}

std::size_t style_of(const Plot& plot, std::size_t series) {
  return plot.series[series].style.value_or(series);
}

std::vector<LegendEntry> legend_of(const std::vector<Plot>& panels) {
  std::map<std::size_t, LegendEntry> entries;
  for (const Plot& plot : panels) {
    for (std::size_t i = 0; i < plot.series.size(); ++i) {
      if (plot.series[i].name.empty()) continue;
      const std::size_t style = style_of(plot, i);
      LegendEntry& entry = entries.try_emplace(style, LegendEntry{style, plot.series[i].name}).first->second;
      (plot.groups.empty() ? entry.has_line : entry.has_bar) = true;
    }
  }
  std::vector<LegendEntry> legend;
  legend.reserve(entries.size());
  for (auto& [style, entry] : entries) legend.push_back(std::move(entry));
  return legend;
}

/// Places the entries row by row, in columns as wide as the longest name needs. Returns the number of rows.
int place(std::vector<LegendEntry>& legend, int width) {
  std::size_t longest = 0;
  for (const LegendEntry& entry : legend) longest = std::max(longest, entry.name.size());
  const int column = kSample + 36 + static_cast<int>(longest) * kFontSize * 6 / 10;
  const auto entries = static_cast<int>(legend.size());
  const int most_columns = std::clamp(width / column, 1, std::max(entries, 1));
  const int rows = (entries + most_columns - 1) / most_columns;
  const int columns = rows == 0 ? 1 : (entries + rows - 1) / rows;
  for (int i = 0; i < entries; ++i) {
    LegendEntry& entry = legend[static_cast<std::size_t>(i)];
    entry.left = std::max((width - columns * column) / 2, 0) + i % columns * column + 18;
    entry.row = i / columns;
  }
  return rows;
}

Layout layout_of(const std::vector<Plot>& panels) {
  Layout layout;
  const auto count = static_cast<int>(panels.size());
  layout.frame_width = count == 1 ? 660 : count == 2 ? 450 : 330;
  layout.width = count * (kLeft + layout.frame_width + kRight);
  layout.legend = legend_of(panels);
  layout.legend_height = place(layout.legend, layout.width) * kLegendRow;
  int title_lines = 0;
  bool is_shaded = false;
  for (const Plot& plot : panels) {
    title_lines = std::max(title_lines, wrapped(plot.title, layout.frame_width).lines);
    is_shaded |= !plot.shaded.empty();
  }
  layout.top = kTop + kLine * (title_lines + (is_shaded ? 1 : 0));
  layout.height = layout.top + kHeight + kBottom + layout.legend_height;
  return layout;
}

std::string number(double value) { return std::isfinite(value) ? fmt::format("{}", value) : "NaN"; }

std::string color(std::size_t style) { return fmt::format("lc rgb '{}'", kColors[style % kColors.size()]); }
std::string dashes(std::size_t style) { return fmt::format("dt {}", kDashes[style % kDashes.size()]); }
std::string marker(std::size_t style) { return fmt::format("pt {}", kMarkers[style % kMarkers.size()]); }
std::string bar_look(std::size_t style) {
  return fmt::format("{} lw 1.5 fs {} border", color(style), kFills[style % kFills.size()]);
}

/// The lower end of bars: 0, or on a logarithmic axis the power of ten below all that is shown.
double bar_base(const Plot& plot) {
  if (!plot.y.is_logarithmic) return 0;
  if (plot.y.low) return *plot.y.low;
  double least = std::numeric_limits<double>::infinity();
  for (const Series& series : plot.series) {
    for (const auto* values : {&series.y, &series.low}) {
      for (const double value : *values) {
        if (value > 0) least = std::min(least, value);
      }
    }
  }
  return std::pow(10, std::ceil(std::log10(least)) - 1);
}

struct Range {
  std::optional<double> low, high;
};

/// A little wider than the data when single points are shown, so that none lies on the frame.
Range x_range(const Plot& plot) {
  Range range{plot.x.low, plot.x.high};
  double low = std::numeric_limits<double>::infinity();
  double high = -low;
  const auto scaled = [&](double x) { return plot.x.is_logarithmic ? std::log(x) : x; };
  for (const Series& series : plot.series) {
    if (series.x.size() > kMostMarkers) return range;
    for (const double x : series.x) {
      if (!std::isfinite(scaled(x))) continue;
      low = std::min(low, scaled(x));
      high = std::max(high, scaled(x));
    }
  }
  if (!(low < high)) return range;
  const double margin = 0.03 * (high - low);
  const auto unscaled = [&](double x) { return plot.x.is_logarithmic ? std::exp(x) : x; };
  if (!range.low) range.low = unscaled(low - margin);
  if (!range.high) range.high = unscaled(high + margin);
  return range;
}

std::string axis(char name, const Axis& axis, const Range& range) {
  std::string script = fmt::format("set {}label {}\n", name, gnuplot_quoted(axis.label));
  script += fmt::format("{} logscale {}\n", axis.is_logarithmic ? "set" : "unset", name);
  const auto end = [](std::optional<double> value) { return value ? number(*value) : "*"; };
  script += fmt::format("set {}range [{}:{}]\n", name, end(range.low), end(range.high));
  if (axis.tics.empty()) return script + fmt::format("set {}tics scale default autofreq format '%g'\n", name);
  std::string tics;
  for (const double tic : axis.tics) tics += (tics.empty() ? "" : ", ") + number(tic);
  return script + fmt::format("set {}tics scale default ({}) format '%g'\n", name, tics);
}

std::string group_axis(const Plot& plot, int frame_width) {
  const double width = frame_width / (static_cast<double>(plot.groups.size()) + 0.2);
  std::string tics;
  for (std::size_t i = 0; i < plot.groups.size(); ++i) {
    std::string label;
    for (const char c : plot.groups[i]) label += c == '%' ? "%%" : std::string(1, c);  // it is a format
    tics += fmt::format("{}{} {}", i == 0 ? "" : ", ", wrapped(label, width).text, i);
  }
  return fmt::format("unset logscale x\nset xlabel {}\nset xrange [-0.6:{}]\nset xtics ({}) scale 0\n",
                     gnuplot_quoted(plot.x.label), static_cast<double>(plot.groups.size()) - 0.4, tics);
}

/// Grey ground and its labels; first, so that all else is drawn over it.
std::string shading(const Plot& plot) {
  std::string script;
  for (const ShadedRange& range : plot.shaded) {
    script += fmt::format(
        "set object rectangle from first {}, graph 0 to first {}, graph 1 fc rgb '#e4e4e4' fs solid noborder "
        "behind\n",
        range.from, range.to);
    script += fmt::format("set label {} at first {}, graph 1.035 center tc rgb '#555555'\n",
                          gnuplot_quoted(range.label), (range.from + range.to) / 2);
  }
  return script;
}

/// The data of a series as a named block of gnuplot: x, y, low, high and, for bars, left and right.
std::string data_block(const Plot& plot, std::size_t index, const std::string& name) {
  const Series& series = plot.series[index];
  const double width = kBarShare / static_cast<double>(plot.series.size());
  std::string block = name + " << END\n";
  for (std::size_t i = 0; i < series.y.size(); ++i) {
    const double left = static_cast<double>(i) - kBarShare / 2 + static_cast<double>(index) * width;
    const double x = plot.groups.empty() ? series.x[i] : left + width / 2;
    const bool has_interval = !series.low.empty() && std::isfinite(series.y[i]);
    block += fmt::format("{} {} {} {} {} {}\n", number(x), number(series.y[i]),
                         number(has_interval ? series.low[i] : series.y[i]),
                         number(has_interval ? series.high[i] : series.y[i]), number(left + 0.05 * width),
                         number(left + 0.95 * width));
  }
  return block + "END\n";
}

/// From low to high with a bar across each end. Not gnuplot's error bars: they blot out their middle.
std::string interval(const std::string& color) {
  return " using 1:3:(0):($4-$3) with vectors heads size graph 0.007,90 dt 1 lw 1.5 " + color;
}

std::vector<std::string> bar_elements(const Plot& plot, std::size_t index, const std::string& data) {
  std::vector<std::string> parts = {fmt::format("{} using 1:2:5:6:({}):2 with boxxyerror {}", data,
                                                bar_base(plot), bar_look(style_of(plot, index)))};
  if (!plot.series[index].low.empty()) parts.push_back(data + interval("lc rgb '#333333'"));
  return parts;
}

std::vector<std::string> line_elements(const Plot& plot, std::size_t index, const std::string& data) {
  const Series& series = plot.series[index];
  const std::size_t style = style_of(plot, index);
  std::vector<std::string> parts;
  if (!series.low.empty()) {
    parts.push_back(series.spread == Series::Spread::kBars
                        ? data + interval(color(style))
                        : data + " using 1:3:4 with filledcurves fs transparent solid 0.2 noborder " +
                              color(style));
  }
  const std::string sparse =
      series.y.size() > kMostMarkers ? fmt::format("pointnumber {}", kMostMarkers) : "";
  parts.push_back(fmt::format("{} using 1:2 with linespoints {} {} {} lw 2 {}", data, color(style),
                              dashes(style), marker(style), sparse));
  return parts;
}

std::string panel(const Plot& plot, const Layout& layout, int index, int count) {
  const double slot = static_cast<double>(layout.width) / count;
  const auto across = [&](double pixels) { return pixels / layout.width; };
  const auto up = [&](double pixels) { return pixels / layout.height; };
  std::string script = "unset label\nunset object\n";
  script += fmt::format(
      "set lmargin at screen {:.6f}\nset rmargin at screen {:.6f}\nset bmargin at screen {:.6f}\nset tmargin "
      "at screen {:.6f}\n",
      across(index * slot + kLeft), across((index + 1) * slot - kRight), up(kBottom + layout.legend_height),
      up(kBottom + layout.legend_height + kHeight));
  script += fmt::format("set title {} font ',{}' offset 0,{}\n", wrapped(plot.title, layout.frame_width).text,
                        kFontSize + 1, plot.shaded.empty() ? 0 : 1);
  const bool is_bars = !plot.groups.empty();
  script += is_bars ? group_axis(plot, layout.frame_width) : axis('x', plot.x, x_range(plot));
  script += axis('y', plot.y, {is_bars && plot.y.is_logarithmic ? bar_base(plot) : plot.y.low, plot.y.high});
  script += shading(plot);
  std::string command;
  for (std::size_t i = 0; i < plot.series.size(); ++i) {
    const std::string data = fmt::format("$data_{}_{}", index, i);
    // In the order in which the parts lie over each other.
    for (const std::string& element : is_bars ? bar_elements(plot, i, data) : line_elements(plot, i, data)) {
      command += (command.empty() ? "plot " : ", \\\n  ") + element + " notitle";
    }
  }
  return script + command + "\n";
}

/// A plot of its own, in pixels, that shows a sample and the name of each entry.
std::string legend(const Layout& layout) {
  if (layout.legend.empty()) return "";
  const int height = layout.legend_height + 8;
  std::string script = "unset label\nunset object\nunset title\nunset xlabel\nunset ylabel\nunset tics\n";
  script += fmt::format("unset border\nunset logscale\nset xrange [0:{}]\nset yrange [0:{}]\n", layout.width,
                        height);
  script += "set lmargin at screen 0\nset rmargin at screen 1\nset bmargin at screen 0\n";
  script += fmt::format("set tmargin at screen {:.6f}\n", static_cast<double>(height) / layout.height);
  std::string command;
  const auto add = [&command](const std::string& element) {
    command += (command.empty() ? "plot " : ", \\\n  ") + element + " notitle";
  };
  for (const LegendEntry& entry : layout.legend) {
    const int y = height - kLegendRow / 2 - entry.row * kLegendRow;
    const int line = entry.left + (entry.has_bar ? kSample / 2 : 0);  // beside the bar, when it is both
    const int right = entry.left + kSample;
    script += fmt::format("set label {} at {}, {} left\n", gnuplot_quoted(entry.name), right + 8, y);
    if (entry.has_bar) {
      add(fmt::format("'+' using ({0}):({1}):({0}):({2}):({3}):({4}) every ::0::0 with boxxyerror {5}",
                      entry.left, y, entry.has_line ? line - 6 : right, y - 7, y + 7, bar_look(entry.style)));
    }
    if (entry.has_line) {
      add(fmt::format("'+' using ({}):({}):({}):(0) every ::0::0 with vectors nohead {} {} lw 2", line, y,
                      right - line, color(entry.style), dashes(entry.style)));
      add(fmt::format("'+' using ({}):({}) every ::0::0 with points {} {}", (line + right) / 2, y,
                      color(entry.style), marker(entry.style)));
    }
  }
  return script + command + "\n";
}

std::string picture(const std::vector<Plot>& panels, const Layout& layout, double point_size) {
  std::string script = fmt::format("reset\nset pointsize {}\n", point_size);
  script += "set multiplot\nset border 3 lc rgb '#444444'\nset tics nomirror\n";
  script += "set grid ytics lt 1 lc rgb '#dddddd' lw 0.6\nunset key\n";
  for (std::size_t i = 0; i < panels.size(); ++i) {
    script += panel(panels[i], layout, static_cast<int>(i), static_cast<int>(panels.size()));
  }
  return script + legend(layout) + "unset multiplot\nunset output\n";
}

}  // namespace

std::string gnuplot_quoted(std::string_view text) {
  std::string quoted = "'";
  for (const char c : text) {
    if (c == '\'') quoted += '\'';
    quoted += static_cast<unsigned char>(c) < ' ' ? ' ' : c;
  }
  return quoted + "'";
}

std::string gnuplot_script(const std::vector<Plot>& panels) {
  const Layout layout = layout_of(panels);
  std::string script = "set encoding utf8\n";
  for (std::size_t p = 0; p < panels.size(); ++p) {
    for (std::size_t i = 0; i < panels[p].series.size(); ++i) {
      script += data_block(panels[p], i, fmt::format("$data_{}_{}", p, i));
    }
  }
  // Twice the size for screens with fine pixels.
  script += fmt::format(
      "set terminal pngcairo noenhanced size {},{} font 'Sans,{}' fontscale 1.5 linewidth 2 pointscale 2 "
      "background 'white'\n"
      "set output 'plot.png'\n{}",
      2 * layout.width, 2 * layout.height, kFontSize, picture(panels, layout, 1.1));
  script += fmt::format(
      "set terminal svg noenhanced size {},{} dynamic font 'sans-serif,{}' background 'white'\n"
      "set output 'plot.svg'\n{}",
      layout.width, layout.height, kFontSize, picture(panels, layout, 0.75));
  return script;
}

}  // namespace evermap
