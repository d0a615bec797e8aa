// SPDX-FileCopyrightText: 2026 the evermap authors
// SPDX-License-Identifier: BSD-3-Clause
#include <algorithm>
#include <cmath>

#include <evermap/evaluation/observed_surface.hpp>

namespace evermap {
namespace {

bool is_before(const Eigen::Vector3d& a, const Eigen::Vector3d& b) {
  return std::lexicographical_compare(a.begin(), a.end(), b.begin(), b.end());
}

}  // namespace

std::vector<std::uint32_t> ObservedSurface::add_surface(const Points& points) {
  std::vector<std::uint32_t> indices(points.size());
  std::vector<std::size_t> added;
  for (std::size_t i = 0; i < points.size(); ++i) {
    const auto key = cells_.key(points[i]);
    const auto known = key ? find(cell_of_[key->bits()], points[i]) : std::nullopt;
    indices[i] = known.value_or(static_cast<std::uint32_t>(points_.size() + added.size()));
    if (!known) added.push_back(i);
  }
  points_.reserve(points_.size() + added.size());
  std::unordered_set<std::uint64_t> touched;
  for (const std::size_t i : added) {
    points_.push_back(points[i]);
    const auto key = cells_.key(points[i]);
    if (!key) continue;
    cell_of_[key->bits()].points.push_back(indices[i]);
    touched.insert(key->bits());
  }
  is_observed_.resize(points_.size(), false);
  for (const std::uint64_t key : touched) {
    Cell& cell = cell_of_[key];
    std::sort(cell.points.begin(), cell.points.end(),
              [&](std::uint32_t a, std::uint32_t b) { return is_before(points_[a], points_[b]); });
    cell.points.shrink_to_fit();
    cell.open = cell.points.size();
  }
  return indices;
}

std::optional<std::uint32_t> ObservedSurface::find(const Cell& cell, const Eigen::Vector3d& p_map) const {
  const auto found =
      std::lower_bound(cell.points.begin(), cell.points.end(), p_map,
                       [&](std::uint32_t a, const Eigen::Vector3d& p) { return is_before(points_[a], p); });
  if (found == cell.points.end() || points_[*found] != p_map) return std::nullopt;
  return *found;
}

void ObservedSurface::add_ends(const Points& ends) {
  // No two points of a cube are further apart than this; a little more for rounding.
  const double diagonal = std::sqrt(3.0) * cubes_.edge * (1 + 1e-9);
  const Eigen::Vector3d reach = Eigen::Vector3d::Constant(reach_ + diagonal);
  for (const Eigen::Vector3d& end : ends) {
    const auto cube = cubes_.key(end);
    if (!cube || taken_cubes_.contains(cube->bits())) continue;
    const auto low = cells_.voxel(end - reach);
    const auto high = cells_.voxel(end + reach);
    if (!low || !high) continue;  // cannot be: cells reach further than cubes
    bool leaves_more = false;
    for (int x = low->x(); x <= high->x(); ++x) {
      for (int y = low->y(); y <= high->y(); ++y) {
        for (int z = low->z(); z <= high->z(); ++z) {
          const auto cell = cell_of_.find(VoxelKey::from_voxel({x, y, z}).bits());
          if (cell == cell_of_.end() || cell->second.open == 0) continue;
          leaves_more |= mark(cell->second, end, diagonal);
        }
      }
    }
    if (leaves_more) taken_cubes_.insert(cube->bits());
  }
}

bool ObservedSurface::mark(Cell& cell, const Eigen::Vector3d& end, double diagonal) {
  bool leaves_more = false;
  for (const std::uint32_t i : cell.points) {
    if (is_observed_[i]) continue;
    const double distance = (points_[i] - end).norm();
    if (distance <= reach_) {
      is_observed_[i] = true;
      --cell.open;
    } else if (distance <= reach_ + diagonal) {
      leaves_more = true;
    }
  }
  return leaves_more;
}

std::size_t ObservedSurface::memory_bytes() const {
  constexpr std::size_t kNode = 2 * sizeof(void*);  // of a hash table, beside the value
  std::size_t bytes = sizeof(*this) + points_.capacity() * sizeof(Eigen::Vector3d) +
                      is_observed_.capacity() / 8 + taken_cubes_.size() * (kNode + sizeof(std::uint64_t)) +
                      (taken_cubes_.bucket_count() + cell_of_.bucket_count()) * sizeof(void*);
  for (const auto& [key, cell] : cell_of_) {
    bytes += kNode + sizeof(key) + sizeof(cell) + cell.points.capacity() * sizeof(std::uint32_t);
  }
  return bytes;
}

}  // namespace evermap
