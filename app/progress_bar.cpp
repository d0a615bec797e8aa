// SPDX-FileCopyrightText: 2026 the evermap authors
// SPDX-License-Identifier: BSD-3-Clause
#include "progress_bar.hpp"

#include <cstdio>
#include <unistd.h>
#include <utility>

#include <fmt/core.h>

namespace evermap {

ProgressBar::ProgressBar(std::size_t total, std::string unit)
    : total_(total), unit_(std::move(unit)), is_shown_(::isatty(STDERR_FILENO) == 1) {
  show(0);
}

ProgressBar::~ProgressBar() { clear(); }

void ProgressBar::show(std::size_t done) const {
  if (!is_shown_ || total_ == 0) return;
  constexpr std::size_t kWidth = 40;
  const std::string bar = fmt::format("\r{:█<{}}{:░<{}} {} of {} {}", "", done * kWidth / total_, "",
                                      kWidth - done * kWidth / total_, done, total_, unit_);
  std::fputs(bar.c_str(), stderr);
  std::fflush(stderr);
}

void ProgressBar::say(const std::string& line) const {
  clear();
  std::fputs((line + "\n").c_str(), stderr);
}

/// Leaves the line empty for whatever is printed next.
void ProgressBar::clear() const {
  if (is_shown_) std::fputs("\r\x1b[K", stderr);
}

}  // namespace evermap
