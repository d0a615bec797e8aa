// SPDX-FileCopyrightText: 2026 the evermap authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstddef>
#include <functional>
#include <vector>

#include "experiments/comparison.hpp"

namespace evermap {

/// Lets the mappers take the same scans in turns, so that whatever else the machine does meets all of them
/// alike, on one thread. Returns each mapper's CPU time [s] of each scan, without the first third of the
/// scans, in which maps still learn the place. `next(i)`: the i-th scan, and the pose that it was taken from;
/// it is not timed.
///
/// Each mapper has a thread of its own, and with it an arena of the allocator: what one mapper freed is
/// not tidied up in the time of the next. REQUIRES: no mapper is null.
std::vector<std::vector<double>> time_in_turns(const Mappers& mappers, std::size_t scans,
                                               const std::function<AlignedScan(std::size_t)>& next);

}  // namespace evermap
