// SPDX-FileCopyrightText: 2026 the evermap authors
// SPDX-License-Identifier: BSD-3-Clause
#include <algorithm>
#include <cmath>

#include <evermap/simulation/scenario.hpp>

namespace evermap {

double Schedule::at(double time) const {
  const auto after =
      std::find_if(points_.begin(), points_.end(), [&](const auto& point) { return point.first > time; });
  if (after == points_.begin()) return points_.front().second;
  if (after == points_.end()) return points_.back().second;
  const auto before = after - 1;
  return std::lerp(before->second, after->second, (time - before->first) / (after->first - before->first));
}

double Schedule::most() const {
  double most = points_.front().second;
  for (const auto& [time, value] : points_) most = std::max(most, value);
  return most;
}

bool ObjectState::changes() const {
  if (where.route) return true;
  const auto varies = [](const auto& of) {
    if constexpr (requires { of.height; }) return !of.height.is_constant();
    return false;
  };
  return std::visit(varies, shape);
}

}  // namespace evermap
