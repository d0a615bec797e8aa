// SPDX-FileCopyrightText: 2026 the evermap authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <filesystem>
#include <string>
#include <string_view>
#include <utility>
#include <variant>
#include <vector>

namespace evermap {

/// A table of a page. Numbers stand to the right with `digits` decimals; a number that is not finite is shown
/// as a dash.
struct HtmlTable {
  enum class Best { kNone, kHighest, kLowest };
  struct Column {
    std::string title;        ///< with its unit, as in "AHD [m]"
    Best best = Best::kNone;  ///< which number is marked; all that look the same as it are, too
    int digits = 3;
  };
  using Cell = std::variant<std::string, double>;

  std::string caption;
  std::vector<Column> columns;
  std::vector<std::vector<Cell>> rows;  ///< each as long as `columns`
};

/// A page that tells of experiments, in one file: pictures are part of it, nothing is loaded, no script runs.
/// It reads on a phone, on paper and on a dark screen. All text is plain text and shown as it is. The same
/// calls give the same bytes.
class HtmlReport {
 public:
  explicit HtmlReport(std::string_view title);

  void heading(std::string_view text);
  void paragraph(std::string_view text);
  /// Commands or their output, line by line.
  void code(std::string_view text);
  /// A box of names and values: the machine, versions.
  void facts(const std::vector<std::pair<std::string, std::string>>& facts);
  /// Throws std::invalid_argument when a row is not as long as the columns.
  void table(const HtmlTable& table);
  /// A picture, .svg or .png. Throws IoError when it cannot be read or is of another kind.
  void figure(const std::filesystem::path& picture, std::string_view caption);

  std::string html() const;
  /// Atomically. Throws IoError when the file cannot be written.
  void save(const std::filesystem::path& path) const;

 private:
  std::string title_;  ///< escaped
  std::string body_;
  int figures_ = 0;
};

}  // namespace evermap
