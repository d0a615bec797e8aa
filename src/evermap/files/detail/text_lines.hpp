// SPDX-FileCopyrightText: 2026 the evermap authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <charconv>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include <evermap/files/detail/input_file.hpp>

namespace evermap {

/// Cuts the next token, a run of characters other than blanks, off the front of `text`; empty at its end.
std::string_view next_token(std::string_view& text);

/// `token` in quotes for an error message: shortened, and on one line whatever it holds.
std::string in_quotes(std::string_view token);

/// The number that the whole of `token` spells, in the C locale whatever the program's is; NaN and infinity
/// count as numbers.
std::optional<double> parse_number(std::string_view token);

/// The whole number, or the count (0, 1, 2, ...), that all of `token` spells in decimal digits.
std::optional<std::int64_t> parse_integer(std::string_view token);
std::optional<std::uint64_t> parse_count(std::string_view token);

/// Walks the lines of a text, or of the text at the front of a binary file. Lines end with LF or CR LF.
/// Keeps a reference to the file. Not thread safe.
class TextLines {
 public:
  explicit TextLines(const InputFile& file) : file_(file) {}

  /// Steps to the next line; false at the end of the file.
  bool next();
  /// Steps to the next line that is not blank; false at the end of the file.
  bool next_filled();

  std::string_view line() const { return line_; }   ///< the line stepped to, without its end
  std::uint64_t number() const { return number_; }  ///< of that line, from 1
  std::size_t offset() const { return offset_; }    ///< [bytes] where the line after it begins
  std::size_t remaining() const { return file_.bytes().size() - offset_; }  ///< [bytes] after that line

  /// Replaces `values` by the numbers of the line, or of a part of it. Throws FileError at this line when a
  /// token is no number.
  void read_numbers(std::vector<double>& values) const { read_numbers(line_, values); }
  void read_numbers(std::string_view part, std::vector<double>& values) const;

  [[noreturn]] void fail(const std::string& message) const { file_.fail_at_line(number_, message); }

 private:
  const InputFile& file_;
  std::string_view line_;
  std::uint64_t number_ = 0;
  std::size_t offset_ = 0;
};

}  // namespace evermap
