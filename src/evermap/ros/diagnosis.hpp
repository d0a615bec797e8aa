// SPDX-FileCopyrightText: 2026 the evermap authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <string>
#include <utility>
#include <vector>

namespace evermap {

/// What a robot's health monitor is told.
struct Diagnosis {
  enum Level { kOk = 0, kWarning = 1, kError = 2 };

  Level level = kOk;
  std::string message;
  std::vector<std::pair<std::string, std::string>> values;
};

}  // namespace evermap
