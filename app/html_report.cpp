// SPDX-FileCopyrightText: 2026 the evermap authors
// SPDX-License-Identifier: BSD-3-Clause
#include "html_report.hpp"

#include <cmath>
#include <cstdint>
#include <fstream>
#include <iterator>
#include <optional>
#include <stdexcept>

#include <fmt/format.h>

#include <evermap/io/atomic_file.hpp>
#include <evermap/io/io_error.hpp>

namespace evermap {
namespace {

// Figures keep a white ground on a dark screen, for their lines are drawn for white.
constexpr std::string_view kStyle = R"(
:root { color-scheme: light dark; --ink: #1d2125; --faint: #5c6670; --line: #d5dadf; --ground: #ffffff;
  --box: #f4f6f8; --best: #0a6b4b; }
@media (prefers-color-scheme: dark) {
  :root { --ink: #e3e6e9; --faint: #a0a9b2; --line: #3a424a; --ground: #15191d; --box: #1e242a; --best: #5fd3a8; } }
* { box-sizing: border-box; }
body { margin: 0 auto; padding: 2rem 1.2rem 4rem; max-width: 68rem; color: var(--ink); background: var(--ground);
  font: 1rem/1.6 system-ui, "Segoe UI", "Liberation Sans", Arial, sans-serif; }
h1 { font-size: 1.9rem; line-height: 1.25; margin: 0 0 1.5rem; text-wrap: balance; }
h2 { font-size: 1.3rem; line-height: 1.3; margin: 2.8rem 0 0.8rem; padding-top: 0.9rem;
  border-top: 1px solid var(--line); }
p { max-width: 44rem; margin: 0 0 1rem; overflow-wrap: break-word; }
figure { margin: 1.6rem 0; }
.picture { background: #ffffff; border: 1px solid var(--line); border-radius: 6px; padding: 0.5rem; }
.picture svg, .picture img { display: block; width: 100%; height: auto; }
figcaption { margin-top: 0.5rem; color: var(--faint); font-size: 0.92rem; line-height: 1.45; max-width: 44rem; }
.scroll { overflow-x: auto; }
table { border-collapse: collapse; font-size: 0.86rem; font-variant-numeric: tabular-nums; }
th, td { padding: 0.3rem 0.6rem; text-align: left; border-bottom: 1px solid var(--line); }
th { font-weight: 600; border-bottom: 2px solid var(--line); vertical-align: bottom; }
th:first-child, td:first-child { padding-left: 0.2rem; }
.number { text-align: right; }
.best { font-weight: 700; color: var(--best); }
.missing { color: var(--faint); }
pre { background: var(--box); border: 1px solid var(--line); border-radius: 6px; padding: 0.8rem 1rem; margin: 1rem 0;
  overflow-x: auto; font: 0.88rem/1.5 ui-monospace, "Liberation Mono", Menlo, Consolas, monospace; }
dl { background: var(--box); border: 1px solid var(--line); border-radius: 6px; padding: 0.8rem 1rem; margin: 1.2rem 0;
  display: grid; grid-template-columns: max-content 1fr; gap: 0.15rem 1.2rem; font-size: 0.92rem; }
dt { color: var(--faint); }
dd { margin: 0; overflow-wrap: anywhere; }
@media (max-width: 36rem) { .picture { overflow-x: auto; } .picture svg, .picture img { min-width: 34rem; }
  dl { grid-template-columns: 1fr; gap: 0; } dd { margin-bottom: 0.4rem; } }
@media print { body { max-width: none; padding: 0; } figure, table, pre { break-inside: avoid; } }
)";

std::string escaped(std::string_view text) {
  std::string result;
  for (const char c : text) {
    switch (c) {
      case '&':
        result += "&amp;";
        break;
      case '<':
        result += "&lt;";
        break;
      case '>':
        result += "&gt;";
        break;
      case '"':
        result += "&quot;";
        break;
      default:
        result += c;
    }
  }
  return result;
}

std::string content(const std::filesystem::path& path) {
  std::ifstream file(path, std::ios::binary);
  std::string bytes{std::istreambuf_iterator<char>(file), std::istreambuf_iterator<char>()};
  if (!file || bytes.empty()) throw IoError(path, "the picture cannot be read");
  return bytes;
}

/// RFC 4648.
std::string base64(std::string_view bytes) {
  constexpr std::string_view kDigits = "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
  std::string text;
  text.reserve((bytes.size() + 2) / 3 * 4);
  for (std::size_t i = 0; i < bytes.size(); i += 3) {
    const auto byte = [&](std::size_t k) -> std::uint32_t {
      return k < bytes.size() ? static_cast<unsigned char>(bytes[k]) : 0;
    };
    const std::uint32_t bits = byte(i) << 16 | byte(i + 1) << 8 | byte(i + 2);
    for (std::size_t digit = 0; digit < 4; ++digit) {
      const bool is_padding = i + digit > bytes.size();
      text += is_padding ? '=' : kDigits[bits >> (18 - 6 * digit) & 63];
    }
  }
  return text;
}

/// The tag with the names that it defines or refers to prefixed.
std::string with_prefixed_names(std::string tag, const std::string& prefix) {
  for (const std::string_view mark : {" id='", " id=\"", "href='#", "href=\"#", "url(#"}) {
    for (std::size_t at = tag.find(mark); at != std::string::npos; at = tag.find(mark, at + mark.size())) {
      tag.insert(at + mark.size(), prefix);
    }
  }
  return tag;
}

/// An SVG file as an element of a page. Several drawings of a page share one space of names, so each gets a
/// prefix.
std::string inline_svg(const std::string& file, const std::filesystem::path& path,
                       const std::string& prefix) {
  const std::size_t begin = file.find("<svg");
  if (begin == std::string::npos) throw IoError(path, "it is no SVG drawing");
  std::string element;
  for (std::size_t at = begin; at < file.size();) {
    const std::size_t tag = std::min(file.find('<', at), file.size());
    const std::size_t end = std::min(file.find('>', tag), file.size() - 1) + 1;
    element += file.substr(at, tag - at);
    if (tag < file.size()) element += with_prefixed_names(file.substr(tag, end - tag), prefix);
    at = std::max(end, tag);
  }
  return element;
}

std::string text_of(const HtmlTable::Cell& cell, int digits) {
  if (const auto* text = std::get_if<std::string>(&cell)) return escaped(*text);
  const double value = std::get<double>(cell);
  return std::isfinite(value) ? fmt::format("{:.{}f}", value, digits) : "\u2013";
}

bool is_number(const HtmlTable::Cell& cell) { return std::holds_alternative<double>(cell); }

bool has_numbers(const HtmlTable& table, std::size_t column) {
  for (const auto& row : table.rows) {
    if (is_number(row[column])) return true;
  }
  return false;
}

/// How the best number of a column looks.
std::optional<std::string> best_of(const HtmlTable& table, std::size_t column) {
  const auto [title, best, digits] = table.columns[column];
  if (best == HtmlTable::Best::kNone) return std::nullopt;
  std::optional<double> found;
  for (const auto& row : table.rows) {
    const double* value = std::get_if<double>(&row[column]);
    if (value == nullptr || !std::isfinite(*value)) continue;
    const bool is_better = best == HtmlTable::Best::kHighest ? found < *value : !found || *value < *found;
    if (is_better) found = *value;
  }
  if (!found) return std::nullopt;
  return text_of(*found, digits);
}

std::string table_cells(const HtmlTable& table, const std::vector<HtmlTable::Cell>& row,
                        const std::vector<std::optional<std::string>>& best) {
  std::string cells;
  for (std::size_t c = 0; c < row.size(); ++c) {
    const std::string text = text_of(row[c], table.columns[c].digits);
    std::string kind = has_numbers(table, c) ? "number" : "";
    if (is_number(row[c]) ? !std::isfinite(std::get<double>(row[c])) : !kind.empty()) kind += " missing";
    if (is_number(row[c]) && best[c] == text) kind += " best";
    cells += kind.empty() ? "<td>" : "<td class=\"" + kind + "\">";
    cells += text + "</td>";
  }
  return cells;
}

}  // namespace

HtmlReport::HtmlReport(std::string_view title) : title_(escaped(title)) {}

void HtmlReport::heading(std::string_view text) { body_ += "<h2>" + escaped(text) + "</h2>\n"; }
void HtmlReport::paragraph(std::string_view text) { body_ += "<p>" + escaped(text) + "</p>\n"; }
void HtmlReport::code(std::string_view text) { body_ += "<pre>" + escaped(text) + "</pre>\n"; }

void HtmlReport::facts(const std::vector<std::pair<std::string, std::string>>& facts) {
  body_ += "<dl>\n";
  for (const auto& [name, value] : facts) {
    body_ += "<dt>" + escaped(name) + "</dt><dd>" + escaped(value) + "</dd>\n";
  }
  body_ += "</dl>\n";
}

void HtmlReport::table(const HtmlTable& table) {
  for (const auto& row : table.rows) {
    if (row.size() != table.columns.size()) {
      throw std::invalid_argument("table \"" + table.caption + "\": a row is not as long as the columns");
    }
  }
  body_ += "<figure><div class=\"scroll\"><table>\n<thead><tr>";
  std::vector<std::optional<std::string>> best;
  for (std::size_t c = 0; c < table.columns.size(); ++c) {
    body_ += has_numbers(table, c) ? "<th class=\"number\">" : "<th>";
    body_ += escaped(table.columns[c].title) + "</th>";
    best.push_back(best_of(table, c));
  }
  body_ += "</tr></thead>\n<tbody>\n";
  for (const auto& row : table.rows) body_ += "<tr>" + table_cells(table, row, best) + "</tr>\n";
  body_ += "</tbody></table></div>";
  if (!table.caption.empty()) body_ += "<figcaption>" + escaped(table.caption) + "</figcaption>";
  body_ += "</figure>\n";
}

void HtmlReport::figure(const std::filesystem::path& picture, std::string_view caption) {
  const std::string text = escaped(caption);
  std::string element;
  if (picture.extension() == ".svg") {
    element = inline_svg(content(picture), picture, fmt::format("figure{}-", figures_));
  } else if (picture.extension() == ".png") {
    element = "<img alt=\"" + text + "\" src=\"data:image/png;base64," + base64(content(picture)) + "\">";
  } else {
    throw IoError(picture, "a picture of a page is .svg or .png");
  }
  ++figures_;
  body_ +=
      "<figure><div class=\"picture\">" + element + "</div><figcaption>" + text + "</figcaption></figure>\n";
}

std::string HtmlReport::html() const {
  return "<!DOCTYPE html>\n<html lang=\"en\">\n<head>\n<meta charset=\"utf-8\">\n"
         "<meta name=\"viewport\" content=\"width=device-width, initial-scale=1\">\n<title>" +
         title_ + "</title>\n<style>" + std::string(kStyle) + "</style>\n</head>\n<body>\n<main>\n<h1>" +
         title_ + "</h1>\n" + body_ + "</main>\n</body>\n</html>\n";
}

void HtmlReport::save(const std::filesystem::path& path) const {
  AtomicFile file(path);
  file.write(html());
  file.commit();
}

}  // namespace evermap
