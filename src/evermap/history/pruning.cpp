// SPDX-FileCopyrightText: 2026 the evermap authors
// SPDX-License-Identifier: BSD-3-Clause
#include <evermap/history/detail/pruning.hpp>

namespace evermap {

std::vector<bool> which_to_keep(std::span<const StoredVersion> versions, std::int64_t keep,
                                std::int64_t keep_daily, std::int64_t now) {
  constexpr std::int64_t kDay = 24 * 3600;
  std::vector<bool> is_kept(versions.size());
  for (std::size_t i = 0; i < versions.size(); ++i) {
    const bool is_newest = i + 1 == versions.size();
    const bool is_last_of_its_day = is_newest || versions[i + 1].time / kDay != versions[i].time / kDay;
    const std::int64_t age = now - versions[i].time;
    is_kept[i] =
        is_newest || !versions[i].tags.empty() || age < keep || (is_last_of_its_day && age < keep_daily);
  }
  return is_kept;
}

}  // namespace evermap
