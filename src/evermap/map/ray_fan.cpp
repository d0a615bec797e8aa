// SPDX-FileCopyrightText: 2026 the evermap authors
// SPDX-License-Identifier: BSD-3-Clause
#include <cmath>
#include <numeric>

#include <evermap/geometry/detail/for_each_index.hpp>
#include <evermap/map/detail/ray_fan.hpp>

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

constexpr double kPadding = 1e-6;   ///< of a cell
constexpr double kRounding = 1e-6;  ///< of a distance as a float, generously
constexpr std::size_t kTargetsPerTask = 512;

}  // namespace

RayFan::RayFan(const VoxelGrid& grid, const Eigen::Vector3d& origin_map, std::span<const Target> targets)
    : origin_((origin_map - grid.origin) / grid.edge), cell_begin_(kRows * kColumns + 1, 0) {
  const auto start = grid.voxel(origin_map);
  if (!start) return;
  start_ = *start;
  const auto direction = [&](const Target& target) -> Eigen::Vector3d {  // [voxels]
    return (target.end_map - origin_map) / grid.edge;
  };
  std::vector<std::uint32_t> cells(targets.size());
  for_each_index(targets.size(), kTargetsPerTask, [&](std::size_t i) {
    const Target& target = targets[i];
    const bool is_looked_at = target.until >= 0 && grid.voxel(target.end_map);
    cells[i] = is_looked_at ? cell_of(direction(target)) : kNoCell;
  });
  // Indices are sorted, serially; the rays themselves are then made where they belong.
  Eigen::AlignedBox3d extent(origin_map);
  for (std::size_t i = 0; i < cells.size(); ++i) {
    if (cells[i] == kNoCell) continue;
    extent.extend(targets[i].end_map);
    ++cell_begin_[cells[i] + 1];
  }
  std::partial_sum(cell_begin_.begin(), cell_begin_.end(), cell_begin_.begin());
  if (cell_begin_.back() == 0) return;
  voxels_ = {*grid.voxel(extent.min()), *grid.voxel(extent.max())};
  std::vector<std::uint32_t> next(cell_begin_.begin(), cell_begin_.end() - 1);
  std::vector<std::uint32_t> sorted(cell_begin_.back());
  for (std::uint32_t i = 0; i < cells.size(); ++i) {
    if (cells[i] != kNoCell) sorted[next[cells[i]]++] = i;
  }
  rays_.resize(sorted.size());
  reach_.resize(sorted.size());
  for_each_index(sorted.size(), kTargetsPerTask, [&](std::size_t i) {
    const Target& target = targets[sorted[i]];
    const Eigen::Vector3d d = direction(target);
    rays_[i] = {target, VoxelRay::towards(origin_, d).inverse, sorted[i]};
    reach_[i] = static_cast<float>((1 + kRounding) * target.until * d.norm());
  });
}

std::uint32_t RayFan::cell_of(const Eigen::Vector3d& d) {
  const double across = std::abs(d.x()) + std::abs(d.y());
  if (across + std::abs(d.z()) == 0) return kNoCell;
  const std::size_t row = part(height(across, d.z()), 1, kRows, 0);
  const std::size_t column = across > 0 ? part(azimuth(d.x(), d.y()), 2, kColumns, 0) : 0;
  return static_cast<std::uint32_t>(row * kColumns + column);
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
