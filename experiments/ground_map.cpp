// SPDX-FileCopyrightText: 2026 the evermap authors
// SPDX-License-Identifier: BSD-3-Clause
#include "experiments/ground_map.hpp"

#include <algorithm>
#include <cmath>
#include <vector>

#include <Eigen/Geometry>

namespace evermap {
namespace {

/// Points a cell apart over a rectangle around zero.
std::vector<Eigen::Vector2d> lattice(const Eigen::Vector2d& half) {
  const Eigen::Vector2i steps = (2 * half / GroundMap::kCell).array().floor().cast<int>();
  std::vector<Eigen::Vector2d> offsets;
  offsets.reserve(static_cast<std::size_t>(steps.x() + 1) * static_cast<std::size_t>(steps.y() + 1));
  for (int i = 0; i <= steps.x(); ++i) {
    for (int j = 0; j <= steps.y(); ++j) offsets.push_back(GroundMap::kCell * Eigen::Vector2d(i, j) - half);
  }
  return offsets;
}

}  // namespace

std::uint64_t GroundMap::key(const Eigen::Vector2d& xy) {
  const auto x = static_cast<std::uint32_t>(static_cast<std::int32_t>(std::floor(xy.x() / kCell)));
  const auto y = static_cast<std::uint32_t>(static_cast<std::int32_t>(std::floor(xy.y() / kCell)));
  return std::uint64_t{x} << 32 | y;
}

GroundMap::GroundMap(const Points& surface) {
  constexpr double kLow = 0.4;   // [m] above the lowest: more than kerbs and noise
  constexpr double kHigh = 2.2;  // [m] higher is above vehicles: trees, signs
  for (const Eigen::Vector3d& p : surface) {
    Column& column = columns_.try_emplace(key(p.head<2>()), Column{p.z()}).first->second;
    column.lowest = std::min(column.lowest, p.z());
  }
  for (const Eigen::Vector3d& p : surface) {
    Column& column = columns_.at(key(p.head<2>()));
    const double height = p.z() - column.lowest;
    if (height > kLow && height < kHigh) ++column.standing;
  }
}

std::optional<double> GroundMap::height(const Eigen::Vector2d& xy) const {
  const auto found = columns_.find(key(xy));
  if (found == columns_.end()) return std::nullopt;
  return found->second.lowest;
}

bool GroundMap::is_free(const Eigen::Vector2d& center, double yaw, const Eigen::Vector2d& half) const {
  constexpr double kUneven = 0.35;  // [m] between the lowest and the highest cell
  const Eigen::Rotation2Dd turn(yaw);
  std::size_t seen = 0;
  double lowest = INFINITY;
  double highest = -INFINITY;
  const std::vector<Eigen::Vector2d> cells = lattice(half);
  for (const Eigen::Vector2d& offset : cells) {
    const auto found = columns_.find(key(center + turn * offset));
    if (found == columns_.end()) continue;
    if (found->second.standing > 0) return false;
    ++seen;
    lowest = std::min(lowest, found->second.lowest);
    highest = std::max(highest, found->second.lowest);
  }
  return 10 * seen > 8 * cells.size() && highest - lowest < kUneven;
}

std::size_t GroundMap::standing(const Eigen::Vector2d& center, double edge) const {
  std::size_t points = 0;
  for (const Eigen::Vector2d& offset : lattice(Eigen::Vector2d::Constant((edge - kCell) / 2))) {
    const auto found = columns_.find(key(center + offset));
    if (found != columns_.end()) points += found->second.standing;
  }
  return points;
}

}  // namespace evermap
