// SPDX-FileCopyrightText: 2026 the evermap authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <future>
#include <sys/resource.h>
#include <unistd.h>
#include <utility>

namespace evermap {

/// From now on this thread takes what time the others leave: a robot's scans go before. Where the system does
/// not grant that, they share.
inline void step_back() {
  constexpr int kNice = 10;
  ::setpriority(PRIO_PROCESS, static_cast<id_t>(::gettid()), kNice);
}

/// Runs task() in a thread that steps back.
template <class Task>
auto in_background(Task task) {
  return std::async(std::launch::async, [task = std::move(task)] {
    step_back();
    return task();
  });
}

}  // namespace evermap
