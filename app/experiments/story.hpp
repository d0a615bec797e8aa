// SPDX-FileCopyrightText: 2026 the evermap authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <filesystem>
#include <string>
#include <variant>
#include <vector>

#include "html_report.hpp"

namespace evermap {

struct Heading {
  std::string text;
};
struct Paragraph {
  std::string text;
};
struct Figure {
  std::filesystem::path picture;  ///< in the experiments' folder
  std::string caption;
};
using Block = std::variant<Heading, Paragraph, HtmlTable, Figure>;

/// What a good map should reach, and what evermap reached.
struct Aim {
  std::string where;  ///< the data
  std::string what;
  std::string reached;
  bool is_met;
};

/// One line of the overview: SA, DA and AHD [m] of OctoMap and of evermap.
struct Glance {
  std::string where;
  double octomap_kept, evermap_kept;      ///< SA
  double octomap_erased, evermap_erased;  ///< DA
  double octomap_apart, evermap_apart;    ///< [m] AHD
};

/// What an experiment has to say: for the terminal, for a page, for Markdown and for spreadsheets.
struct Story {
  std::string title;
  std::vector<Block> blocks{};
  std::vector<Glance> glances{};
  std::vector<Aim> aims{};
};

void add_to(HtmlReport& page, const Story& story, const std::filesystem::path& folder);
/// The tables alone, for a terminal.
std::string text_of(const Story& story);
/// Figures are linked as files beside the text.
std::string markdown_of(const Story& story);
/// All tables, one below the other, each with a line of its caption.
std::string csv_of(const Story& story);

}  // namespace evermap
