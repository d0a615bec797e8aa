// SPDX-FileCopyrightText: 2026 the evermap authors
// SPDX-License-Identifier: BSD-3-Clause
#include <algorithm>
#include <string>
#include <string_view>
#include <system_error>

#include <evermap/files/detail/gzip.hpp>
#include <evermap/files/file_error.hpp>
#include <evermap/io/detail/file_order.hpp>

namespace evermap {
namespace {

bool is_digit(char c) { return c >= '0' && c <= '9'; }

/// Cuts the digits off the front of `text`, without leading zeros.
std::string_view take_number(std::string_view& text) {
  const auto end = std::find_if_not(text.begin(), text.end(), is_digit);
  std::string_view number = text.substr(0, static_cast<std::size_t>(end - text.begin()));
  text.remove_prefix(number.size());
  number.remove_prefix(std::min(number.find_first_not_of('0'), number.size()));
  return number;
}

/// Whether a name comes before another one as a person counts: a run of digits is a number.
bool counts_before(std::string_view a, std::string_view b) {
  const std::string_view a_whole = a;
  const std::string_view b_whole = b;
  while (!a.empty() && !b.empty()) {
    if (is_digit(a.front()) && is_digit(b.front())) {
      const std::string_view number_a = take_number(a);
      const std::string_view number_b = take_number(b);
      if (number_a.size() != number_b.size()) return number_a.size() < number_b.size();
      if (number_a != number_b) return number_a < number_b;
    } else {
      if (a.front() != b.front()) return a.front() < b.front();
      a.remove_prefix(1);
      b.remove_prefix(1);
    }
  }
  if (a.empty() != b.empty()) return a.empty();
  return a_whole < b_whole;  // 1 and 01
}

std::string stem_of(const std::filesystem::path& file) { return without_gzip(file).stem().string(); }

/// Whether a name is a number with a fraction: a time, as 1305031102.175.
bool is_time(const std::filesystem::path& file) {
  const std::string stem = stem_of(file);
  const std::string_view rest = stem;
  const std::size_t dot = rest.find('.');
  return dot != std::string_view::npos && dot > 0 && dot + 1 < rest.size() &&
         std::all_of(rest.begin(), rest.begin() + static_cast<std::ptrdiff_t>(dot), is_digit) &&
         std::all_of(rest.begin() + static_cast<std::ptrdiff_t>(dot) + 1, rest.end(), is_digit);
}

/// Fractions are compared as such: .25 comes before .5.
bool times_before(const std::filesystem::path& a, const std::filesystem::path& b) {
  const std::string a_name = stem_of(a);
  const std::string b_name = stem_of(b);
  std::string_view a_rest = a_name;
  std::string_view b_rest = b_name;
  const std::string_view a_whole = take_number(a_rest);
  const std::string_view b_whole = take_number(b_rest);
  if (a_whole.size() != b_whole.size()) return a_whole.size() < b_whole.size();
  return a_whole != b_whole ? a_whole < b_whole : a_rest < b_rest;
}

void sort_by_name(std::vector<std::filesystem::path>& files) {
  if (std::all_of(files.begin(), files.end(), is_time)) {
    std::sort(files.begin(), files.end(), times_before);
  } else {
    std::sort(files.begin(), files.end(), [](const auto& a, const auto& b) {
      return counts_before(a.filename().string(), b.filename().string());
    });
  }
}

}  // namespace

std::vector<std::filesystem::path> files_in(const std::filesystem::path& folder,
                                            const std::function<bool(const std::filesystem::path&)>& wanted) {
  std::vector<std::filesystem::path> files;
  std::error_code error;
  for (std::filesystem::directory_iterator entry(folder, error), end; !error && entry != end;
       entry.increment(error)) {
    const std::filesystem::path& file = entry->path();
    std::error_code ignored;
    if (wanted(file) && !file.filename().string().starts_with('.') && entry->is_regular_file(ignored))
      files.push_back(file);
  }
  if (error) throw FileError(folder, "cannot be listed: " + error.message());
  sort_by_name(files);
  return files;
}

}  // namespace evermap
