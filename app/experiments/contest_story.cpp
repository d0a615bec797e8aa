// SPDX-FileCopyrightText: 2026 the evermap authors
// SPDX-License-Identifier: BSD-3-Clause
#include "experiments/contest_story.hpp"

#include <algorithm>
#include <cctype>
#include <cmath>
#include <limits>

#include <fmt/format.h>

#include "experiments/measures.hpp"
#include "picture.hpp"

namespace evermap {
namespace {

using Best = HtmlTable::Best;

/// All but the one that only timing asks for.
std::vector<std::string> rows_of(const Json& result) {
  std::vector<std::string> names = contenders_of(result);
  if (contender_of(result, "OctoMap") != nullptr && contender_of(result, "UFOMap") == nullptr) {
    names.insert(std::find(names.begin(), names.end(), "OctoMap") + 1, "UFOMap");
  }
  return names;
}

HtmlTable table_of(const Json& result, const std::string& caption, std::vector<HtmlTable::Column> columns,
                   const std::vector<std::string>& measures) {
  columns.insert(columns.begin(), {"map", Best::kNone, 0});
  HtmlTable table{caption, std::move(columns), {}};
  for (const std::string& name : rows_of(result)) {
    const bool is_there = contender_of(result, name) != nullptr;
    std::vector<HtmlTable::Cell> row{is_there ? name : name + " (not installed)"};
    for (const std::string& measure : measures) row.emplace_back(at_end(result, name, measure));
    table.rows.push_back(std::move(row));
  }
  return table;
}

}  // namespace

double at_end(const Json& result, const std::string& contender, const std::string& measure) {
  const Json* found = contender_of(result, contender);
  if (found == nullptr) return std::numeric_limits<double>::quiet_NaN();
  if ((*found)["end"].contains(measure)) return number((*found)["end"][measure]);
  return number((*found)["rows"].back().value(measure, Json()));
}

std::vector<double> along(const Json& result, const std::string& contender, const std::string& measure) {
  std::vector<double> values;
  const Json* found = contender_of(result, contender);
  if (found == nullptr) return values;
  for (const Json& row : (*found)["rows"]) values.push_back(number(row[measure]));
  return values;
}

HtmlTable quality_table(const Json& result, const std::string& caption) {
  constexpr auto kHighest = Best::kHighest;
  constexpr auto kLowest = Best::kLowest;
  return table_of(result, caption,
                  {{"SA", kHighest, 4},
                   {"DA", kHighest, 4},
                   {"AA", kHighest, 4},
                   {"COV 0.2", kHighest, 4},
                   {"ACC 0.2", kHighest, 4},
                   {"truth to map [m]", kLowest, 3},
                   {"map to truth [m]", kLowest, 3},
                   {"AHD [m]", kLowest, 3},
                   {"COV 0.2, uncropped", kHighest, 4},
                   {"AHD, uncropped [m]", kLowest, 3}},
                  {"SA", "DA", "AA", "COV 0.2", "ACC 0.2", "truth to map", "map to truth", "AHD",
                   "uncropped COV 0.2", "uncropped AHD"});
}

namespace {

/// COV and ACC at all tolerances.
HtmlTable tolerance_table(const Json& result, const std::string& caption) {
  std::vector<HtmlTable::Column> columns;
  std::vector<std::string> measures;
  for (const char* kind : {"COV ", "ACC "}) {
    for (const char* tolerance : {"0.1", "0.2", "0.5", "l/2", "l"}) {
      measures.push_back(std::string(kind) + tolerance);
      columns.push_back({measures.back(), Best::kHighest, 3});
    }
  }
  return table_of(result, caption, std::move(columns), measures);
}

/// A measure over the scans, one line for each contender.
Plot curves(const Json& result, const Telling::Curve& curve, const std::vector<ShadedRange>& shaded) {
  Plot plot{curve.title, {"scan"}, {curve.is_distance ? "distance [m]" : "share"}, {}, shaded, {}};
  for (const std::string& name : contenders_of(result)) {
    plot.series.push_back(
        {.name = name, .x = along(result, name, "scan"), .y = along(result, name, curve.measure)});
  }
  return plot;
}

constexpr Color kPaper{255, 255, 255};
constexpr Color kInk{40, 40, 40};

Color color_of(char cell) {
  switch (static_cast<Cell>(cell)) {
    case Cell::kKept:
      return {196, 202, 208};
    case Cell::kHole:
      return {213, 94, 0};
    case Cell::kGhost:
      return {0, 114, 178};
    default:
      return kPaper;
  }
}

std::string lower_case(std::string text) {
  std::transform(text.begin(), text.end(), text.begin(), [](unsigned char c) { return std::tolower(c); });
  return text;
}

constexpr int kTitle = Picture::kTextHeight + 12;  // [pixels] above each view
constexpr int kGap = 12;

struct Tiles {
  int columns, rows;  ///< of cells in a view
  int scale;          ///< [pixels] of a cell
  int across;         ///< views side by side
  int width() const { return columns * scale + kGap; }
  int height() const { return rows * scale + kTitle + kGap; }
};

Tiles tiles_for(const Json& picture) {
  constexpr int kWidth = 1400;  // [pixels] about, of two views
  Tiles tiles{static_cast<int>(picture[0].get_ref<const std::string&>().size()),
              static_cast<int>(picture.size()), 1, 2};
  if (tiles.columns > 3 * tiles.rows) tiles.across = 1;
  tiles.scale = std::max(1, kWidth / (tiles.across * tiles.columns));
  return tiles;
}

/// Explains the colours, at the lower end.
void draw_legend(Picture& picture, int y) {
  int x = kGap;
  for (const auto& [cell, text] :
       {std::pair{Cell::kKept, "kept"}, std::pair{Cell::kHole, "hole - missing in the map"},
        std::pair{Cell::kGhost, "ghost - not in the world"}}) {
    picture.fill(x, y, 28, Picture::kTextHeight, color_of(static_cast<char>(cell)));
    picture.write(x + 38, y, text, kInk);
    x += 38 + Picture::text_width(text) + 3 * kGap;
  }
}

/// The maps from above, side by side.
void write_views(const std::filesystem::path& file, const Json& result) {
  const Json& contenders = result["contenders"];
  const Tiles tiles = tiles_for(contenders[0]["picture"]);
  const int down = (static_cast<int>(contenders.size()) + tiles.across - 1) / tiles.across;
  Picture picture(tiles.across * tiles.width() + kGap,
                  down * tiles.height() + 3 * kGap + Picture::kTextHeight, kPaper);
  for (int i = 0; i < static_cast<int>(contenders.size()); ++i) {
    const Json& contender = contenders[static_cast<std::size_t>(i)];
    const int left = kGap + i % tiles.across * tiles.width();
    const int top = kGap + i / tiles.across * tiles.height();
    picture.write(left, top, lower_case(contender["name"]), kInk);
    for (int row = 0; row < tiles.rows; ++row) {
      const auto& cells = contender["picture"][static_cast<std::size_t>(row)].get_ref<const std::string&>();
      for (int column = 0; column < tiles.columns; ++column) {
        picture.fill(left + column * tiles.scale, top + kTitle + row * tiles.scale, tiles.scale, tiles.scale,
                     color_of(cells[static_cast<std::size_t>(column)]));
      }
    }
  }
  draw_legend(picture, picture.height() - kGap - Picture::kTextHeight);
  picture.save_png(file);
}

Glance glance_of(const std::string& where, const Json& result) {
  const auto both = [&](const char* measure) {
    return std::pair(at_end(result, kOctoMap, measure), at_end(result, kEvermap, measure));
  };
  const auto [octomap_kept, evermap_kept] = both("SA");
  const auto [octomap_erased, evermap_erased] = both("DA");
  const auto [octomap_apart, evermap_apart] = both("AHD");
  return {where, octomap_kept, evermap_kept, octomap_erased, evermap_erased, octomap_apart, evermap_apart};
}

/// The outcome in a sentence or two.
std::string verdict(const Glance& g) {
  if (!std::isfinite(g.octomap_kept)) {
    return fmt::format(
        "evermap kept {:.1f} % of the surface that did not change and erased {:.1f} % of what was "
        "gone; map and truth were {:.3f} m apart (AHD).",
        100 * g.evermap_kept, 100 * g.evermap_erased, g.evermap_apart);
  }
  std::string text =
      fmt::format("Of the surface that did not change, OctoMap kept {:.1f} %, evermap {:.1f} %.",
                  100 * g.octomap_kept, 100 * g.evermap_kept);
  if (std::isfinite(g.evermap_erased)) {
    text += fmt::format(" Of what was gone, OctoMap erased {:.1f} %, evermap {:.1f} %.",
                        100 * g.octomap_erased, 100 * g.evermap_erased);
  }
  return text + fmt::format(" Map and truth were {:.3f} m apart with OctoMap, {:.3f} m with evermap (AHD).",
                            g.octomap_apart, g.evermap_apart);
}

}  // namespace

void tell_contest(Story& story, const std::filesystem::path& folder, const std::string& stem,
                  const std::string& data, const Json& result, const Telling& telling) {
  const std::string about = fmt::format("{}, {} scans", data, result["scans"].get<int>());
  story.glances.push_back(glance_of(data, result));
  story.blocks.emplace_back(Heading{data});
  story.blocks.emplace_back(Paragraph{verdict(story.glances.back())});
  if (result["contenders"][0].contains("picture")) {
    write_views(folder / (stem + "_views.png"), result);
    story.blocks.emplace_back(Figure{stem + "_views.png", fmt::format("{} ({}).", telling.view, about)});
  }
  std::vector<Plot> panels;
  for (const Telling::Curve& curve : telling.curves) panels.push_back(curves(result, curve, telling.shaded));
  write_plot(folder / stem, panels);
  story.blocks.emplace_back(Figure{stem + ".svg", fmt::format("{} ({}).", telling.figure, about)});
  story.blocks.emplace_back(quality_table(result, fmt::format("At the end: {}", about)));
  story.blocks.emplace_back(
      tolerance_table(result, fmt::format("Shares within a tolerance [m] at the end: {}", about)));
}

void aim_at_least(Story& story, const std::string& where, const std::string& what, double aimed,
                  double reached) {
  story.aims.push_back(
      {where, fmt::format("{} at least {}", what, aimed), fmt::format("{:.4f}", reached), reached >= aimed});
}

void aim_at_most(Story& story, const std::string& where, const std::string& what, double aimed,
                 double reached) {
  story.aims.push_back(
      {where, fmt::format("{} at most {}", what, aimed), fmt::format("{:.4f}", reached), reached <= aimed});
}

bool is_best(const Json& result, const std::string& measure, bool highest) {
  const double ours = at_end(result, kEvermap, measure);
  const std::vector<std::string> names = contenders_of(result);
  return std::all_of(names.begin(), names.end(), [&](const std::string& name) {
    const double theirs = at_end(result, name, measure);
    return highest ? ours >= theirs : ours <= theirs;
  });
}

double largest_sag(const std::vector<double>& values) {
  double sag = 0;
  double highest = -std::numeric_limits<double>::infinity();
  for (const double value : values) {
    highest = std::max(highest, value);
    sag = std::max(sag, highest - value);
  }
  return sag;
}

}  // namespace evermap
