// SPDX-FileCopyrightText: 2026 the evermap authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include <evermap/history/detail/version_table.hpp>

namespace evermap {

/// One flag a version: whether it is younger than `keep` [s], or younger than `keep_daily` [s] and the last
/// of its day (UTC), or tagged, or the newest. `now` [s] since 1970.
std::vector<bool> which_to_keep(std::span<const StoredVersion> versions, std::int64_t keep,
                                std::int64_t keep_daily, std::int64_t now);

}  // namespace evermap
