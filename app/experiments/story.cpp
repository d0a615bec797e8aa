// SPDX-FileCopyrightText: 2026 the evermap authors
// SPDX-License-Identifier: BSD-3-Clause
#include "experiments/story.hpp"

#include <algorithm>
#include <cmath>

#include <fmt/format.h>

namespace evermap {
namespace {

/// Joins the visitors of a variant's kinds.
template <class... Visitors>
struct Overloaded : Visitors... {
  using Visitors::operator()...;
};
template <class... Visitors>
Overloaded(Visitors...) -> Overloaded<Visitors...>;

std::string cell_text(const HtmlTable& table, std::size_t column, const HtmlTable::Cell& cell) {
  if (const auto* text = std::get_if<std::string>(&cell)) return *text;
  const double value = std::get<double>(cell);
  return std::isfinite(value) ? fmt::format("{:.{}f}", value, table.columns[column].digits) : "-";
}

std::string aligned(const HtmlTable& table) {
  std::vector<std::size_t> widths;
  for (std::size_t c = 0; c < table.columns.size(); ++c) {
    widths.push_back(table.columns[c].title.size());
    for (const auto& row : table.rows) widths[c] = std::max(widths[c], cell_text(table, c, row[c]).size());
  }
  std::string text = fmt::format("{}\n", table.caption);
  for (std::size_t c = 0; c < widths.size(); ++c) {
    const bool is_number = !table.rows.empty() && std::holds_alternative<double>(table.rows[0][c]);
    text += is_number ? fmt::format("{:>{}}  ", table.columns[c].title, widths[c])
                      : fmt::format("{:<{}}  ", table.columns[c].title, widths[c]);
  }
  for (const auto& row : table.rows) {
    text += "\n";
    for (std::size_t c = 0; c < widths.size(); ++c) {
      const std::string cell = cell_text(table, c, row[c]);
      text += std::holds_alternative<double>(row[c]) ? fmt::format("{:>{}}  ", cell, widths[c])
                                                     : fmt::format("{:<{}}  ", cell, widths[c]);
    }
  }
  return text + "\n";
}

std::string markdown(const HtmlTable& table) {
  std::string text = "|";
  for (const auto& column : table.columns) text += fmt::format(" {} |", column.title);
  text += "\n|";
  for (std::size_t c = 0; c < table.columns.size(); ++c) text += "---|";
  for (const auto& row : table.rows) {
    text += "\n|";
    for (std::size_t c = 0; c < row.size(); ++c) text += fmt::format(" {} |", cell_text(table, c, row[c]));
  }
  return text + "\n\n" + (table.caption.empty() ? "" : fmt::format("*{}*\n\n", table.caption));
}

std::string csv_text(std::string text) {
  std::replace(text.begin(), text.end(), '"', '\'');
  return text.find(',') == std::string::npos ? text : fmt::format("\"{}\"", text);
}

std::string csv(const HtmlTable& table) {
  std::string text = fmt::format("# {}\n", table.caption);
  for (std::size_t c = 0; c < table.columns.size(); ++c) {
    if (c > 0) text += ",";
    text += csv_text(table.columns[c].title);
  }
  for (const auto& row : table.rows) {
    text += "\n";
    for (std::size_t c = 0; c < row.size(); ++c) {
      const auto* number = std::get_if<double>(&row[c]);
      if (c > 0) text += ",";
      text += number ? fmt::format("{}", *number) : csv_text(std::get<std::string>(row[c]));
    }
  }
  return text + "\n";
}

}  // namespace

void add_to(HtmlReport& page, const Story& story, const std::filesystem::path& folder) {
  page.heading(story.title);
  const Overloaded add{[&](const Heading& heading) { page.heading(heading.text); },
                       [&](const Paragraph& paragraph) { page.paragraph(paragraph.text); },
                       [&](const HtmlTable& table) { page.table(table); },
                       [&](const Figure& figure) { page.figure(folder / figure.picture, figure.caption); }};
  for (const Block& block : story.blocks) std::visit(add, block);
}

std::string text_of(const Story& story) {
  std::string text = fmt::format("\n== {}\n", story.title);
  for (const Block& block : story.blocks) {
    if (const auto* table = std::get_if<HtmlTable>(&block)) text += fmt::format("\n{}", aligned(*table));
  }
  return text;
}

std::string markdown_of(const Story& story) {
  std::string text = fmt::format("## {}\n\n", story.title);
  const Overloaded add{[&](const Heading& heading) { text += fmt::format("### {}\n\n", heading.text); },
                       [&](const Paragraph& paragraph) { text += paragraph.text + "\n\n"; },
                       [&](const HtmlTable& table) { text += markdown(table); },
                       [&](const Figure& figure) {
                         text += fmt::format("![{}]({})\n\n", figure.caption, figure.picture.string());
                       }};
  for (const Block& block : story.blocks) std::visit(add, block);
  return text;
}

std::string csv_of(const Story& story) {
  std::string text;
  for (const Block& block : story.blocks) {
    const auto* table = std::get_if<HtmlTable>(&block);
    if (table != nullptr) text += fmt::format("{}{}", text.empty() ? "" : "\n", csv(*table));
  }
  return text;
}

}  // namespace evermap
