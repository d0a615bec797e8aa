// SPDX-FileCopyrightText: 2026 the evermap authors
// SPDX-License-Identifier: BSD-3-Clause
#include <cmath>

#include <evermap/map/ray_fan.hpp>

namespace evermap {
namespace {

/// The diamond angle of (x, y), in [-2, 2].
double azimuth(double x, double y) {
  const double slope = y / (std::abs(x) + std::abs(y));
  return x >= 0 ? slope : (y >= 0 ? 2 : -2) - slope;
}

double height(double across, double z) { return z / (across + std::abs(z)); }

/// Least and greatest |x| + |y| of a box.
std::array<double, 2> across(const Eigen::AlignedBox3d& box) {
  std::array<double, 2> sum{0, 0};
  for (int axis = 0; axis < 2; ++axis) {
    const double low = box.min()[axis];
    const double high = box.max()[axis];
    sum[0] += std::max({0.0, low, -high});
    sum[1] += std::max(-low, high);
  }
  return sum;
}

/// Index among `count` equal parts of [-limit, limit]; `padding` keeps rounding from losing a direction.
std::size_t part(double value, double limit, std::size_t count, double padding) {
  const double scaled = (value + limit) * static_cast<double>(count) / (2 * limit) + padding;
  return static_cast<std::size_t>(std::clamp(scaled, 0.0, static_cast<double>(count - 1)));
}

constexpr double kPadding = 1e-6;  // of a cell

}  // namespace

RayFan::RayFan(const VoxelGrid& grid, const Eigen::Vector3d& origin_map, std::span<const Target> targets)
    : origin_((origin_map - grid.origin) / grid.edge), cell_begin_(kRows * kColumns + 1, 0) {
  const auto start = grid.voxel(origin_map);
  if (!start) return;
  start_ = *start;
  std::vector<FanRay> unsorted;
  unsorted.reserve(targets.size());
  for (std::size_t i = 0; i < targets.size(); ++i) {
    const auto end = grid.voxel(targets[i].end_map);
    const Eigen::Vector3d direction = (targets[i].end_map - origin_map) / grid.edge;
    const double across = std::abs(direction.x()) + std::abs(direction.y());
    if (!end || !(targets[i].until >= 0) || !(across + std::abs(direction.z()) > 0)) continue;
    voxels_.extend(*end);
    const std::size_t row = part(height(across, direction.z()), 1, kRows, 0);
    const std::size_t column = across > 0 ? part(azimuth(direction.x(), direction.y()), 2, kColumns, 0) : 0;
    const auto cell = static_cast<std::uint32_t>(row * kColumns + column);
    unsorted.push_back(
        {targets[i], VoxelRay::towards(origin_, direction).inverse, static_cast<std::uint32_t>(i), cell});
    ++cell_begin_[cell + 1];
  }
  if (unsorted.empty()) return;
  voxels_.extend(start_);
  for (std::size_t cell = 1; cell < cell_begin_.size(); ++cell) cell_begin_[cell] += cell_begin_[cell - 1];
  rays_.resize(unsorted.size());
  std::vector<std::uint32_t> next(cell_begin_.begin(), cell_begin_.end() - 1);
  for (const FanRay& ray : unsorted) rays_[next[ray.cell]++] = ray;
}

std::array<RayFan::Cells, 2> RayFan::cells_of(const Eigen::AlignedBox3d& box) const {
  const Eigen::Vector3d& low = box.min();
  const Eigen::Vector3d& high = box.max();
  const Cells none{0, 0, 0, 0};
  if (box.contains(Eigen::Vector3d::Zero())) return {Cells{0, kRows, 0, kColumns}, none};
  const auto [nearest, farthest] = across(box);
  const double bottom = height(low.z() < 0 ? nearest : farthest, low.z());
  const double top = height(high.z() > 0 ? nearest : farthest, high.z());
  Cells cells{part(bottom, 1, kRows, -kPadding), part(top, 1, kRows, kPadding) + 1, 0, kColumns};
  if (nearest == 0) return {cells, none};  // straight above or below: any azimuth

  const std::array<double, 4> corners{azimuth(low.x(), low.y()), azimuth(high.x(), low.y()),
                                      azimuth(low.x(), high.y()), azimuth(high.x(), high.y())};
  const bool across_seam = high.x() < 0 && low.y() < 0 && high.y() >= 0;
  if (!across_seam) {
    const auto [right, left] = std::minmax_element(corners.begin(), corners.end());
    cells.first_column = part(*right, 2, kColumns, -kPadding);
    cells.last_column = part(*left, 2, kColumns, kPadding) + 1;
    return {cells, none};
  }
  Cells other = cells;
  cells.first_column = part(std::min(corners[2], corners[3]), 2, kColumns, -kPadding);
  other.last_column = part(std::max(corners[0], corners[1]), 2, kColumns, kPadding) + 1;
  return {cells, other};
}

}  // namespace evermap
