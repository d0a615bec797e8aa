// SPDX-FileCopyrightText: 2026 the evermap authors
// SPDX-License-Identifier: BSD-3-Clause
#include "progress_bar.hpp"

#include <cstdio>
#include <unistd.h>

#include <fmt/core.h>

namespace evermap {

ProgressBar::ProgressBar(std::size_t total) : total_(total), is_shown_(::isatty(STDERR_FILENO) == 1) {
  show(0);
}

ProgressBar::~ProgressBar() {
  // Leaves the line empty for whatever is printed next.
  if (is_shown_) fmt::print(stderr, "\r\x1b[K");
}

void ProgressBar::show(std::size_t done) const {
  if (!is_shown_ || total_ == 0) return;
  constexpr std::size_t kWidth = 40;
  fmt::print(stderr, "\r{:█<{}}{:░<{}} {} of {} scans", "", done * kWidth / total_, "",
             kWidth - done * kWidth / total_, done, total_);
  std::fflush(stderr);
}

}  // namespace evermap
