// SPDX-FileCopyrightText: 2026 the evermap authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <ctime>

namespace evermap {

/// [s] What a clock shows.
inline double seconds_by(clockid_t clock) {
  timespec now{};
  clock_gettime(clock, &now);
  return static_cast<double>(now.tv_sec) + 1e-9 * static_cast<double>(now.tv_nsec);
}

/// [s] CPU time of this process, of all its threads together.
inline double cpu_seconds() { return seconds_by(CLOCK_PROCESS_CPUTIME_ID); }

/// [s] CPU time of the calling thread.
inline double thread_cpu_seconds() { return seconds_by(CLOCK_THREAD_CPUTIME_ID); }

}  // namespace evermap
