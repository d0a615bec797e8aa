// SPDX-FileCopyrightText: 2026 the evermap authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstddef>
#include <string>

namespace evermap {

/// A bar on the standard error, if that is a terminal; otherwise nothing.
class ProgressBar {
 public:
  explicit ProgressBar(std::size_t total, std::string unit = "scans");
  ~ProgressBar();
  ProgressBar(const ProgressBar&) = delete;
  ProgressBar& operator=(const ProgressBar&) = delete;

  void show(std::size_t done) const;
  /// A line on the standard error that stays, whether or not there is a bar.
  void say(const std::string& line) const;

 private:
  void clear() const;

  std::size_t total_;
  std::string unit_;
  bool is_shown_;
};

}  // namespace evermap
