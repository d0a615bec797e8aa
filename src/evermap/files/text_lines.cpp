// SPDX-FileCopyrightText: 2026 the evermap authors
// SPDX-License-Identifier: BSD-3-Clause
#include <algorithm>

#include <evermap/files/detail/text_lines.hpp>

namespace evermap {
namespace {

constexpr std::string_view kBlanks = " \t\r\v\f";

template <typename Number>
std::optional<Number> parse(std::string_view token) {
  Number value{};
  const char* end = token.data() + token.size();
  const auto [parsed, error] = std::from_chars(token.data(), end, value);
  if (error != std::errc{} || parsed != end) return std::nullopt;
  return value;
}

/// from_chars knows no plus sign, but C programs print it.
std::string_view without_plus(std::string_view token) {
  if (token.size() > 1 && token[0] == '+' && token[1] != '-') token.remove_prefix(1);
  return token;
}

}  // namespace

std::string_view next_token(std::string_view& text) {
  text.remove_prefix(std::min(text.find_first_not_of(kBlanks), text.size()));
  const std::string_view token = text.substr(0, text.find_first_of(kBlanks));
  text.remove_prefix(token.size());
  return token;
}

std::string in_quotes(std::string_view token) {
  constexpr std::size_t kLongest = 40;
  std::string text(token.substr(0, kLongest));
  std::replace_if(
      text.begin(), text.end(), [](char c) { return c < ' ' || c > '~'; }, '?');
  return '\'' + text + (token.size() > kLongest ? "...'" : "'");
}

std::optional<double> parse_number(std::string_view token) { return parse<double>(without_plus(token)); }

std::optional<std::int64_t> parse_integer(std::string_view token) {
  return parse<std::int64_t>(without_plus(token));
}

std::optional<std::uint64_t> parse_count(std::string_view token) { return parse<std::uint64_t>(token); }

bool TextLines::next() {
  const std::string_view rest = file_.bytes().substr(offset_);
  if (rest.empty()) return false;
  const std::size_t length = std::min(rest.find('\n'), rest.size());
  line_ = rest.substr(0, length);
  if (line_.ends_with('\r')) line_.remove_suffix(1);
  offset_ += std::min(length + 1, rest.size());
  ++number_;
  return true;
}

bool TextLines::next_filled() {
  while (next()) {
    if (line_.find_first_not_of(kBlanks) != std::string_view::npos) return true;
  }
  return false;
}

void TextLines::read_numbers(std::string_view part, std::vector<double>& values) const {
  values.clear();
  for (std::string_view token = next_token(part); !token.empty(); token = next_token(part)) {
    const std::optional<double> value = parse_number(token);
    if (!value) fail(in_quotes(token) + " is no number; correct or remove the line");
    values.push_back(*value);
  }
}

}  // namespace evermap
