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

void ObservedSurface::add_surface(const Points& points) {
  std::unordered_map<std::uint64_t, std::size_t> counts;
  for (const Eigen::Vector3d& p : points) {
    if (const auto key = cells_.key(p)) ++counts[key->bits()];
  }
  // To the size that is needed: surfaces are what memory goes to here.
  for (const auto& [key, count] : counts) {
    Points& in_cell = cell_of_[key].points;
    in_cell.reserve(in_cell.size() + count);
  }
  for (const Eigen::Vector3d& p : points) {
    if (const auto key = cells_.key(p)) cell_of_[key->bits()].points.push_back(p);
  }
  for (const auto& [key, count] : counts) {
    Cell& cell = cell_of_[key];
    std::sort(cell.points.begin(), cell.points.end(), is_before);
    cell.points.erase(std::unique(cell.points.begin(), cell.points.end()), cell.points.end());
    cell.points.shrink_to_fit();
    cell.is_observed.assign(cell.points.size(), false);
    cell.open = cell.points.size();
  }
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

bool ObservedSurface::mark(Cell& cell, const Eigen::Vector3d& end, double diagonal) const {
  bool leaves_more = false;
  for (std::size_t i = 0; i < cell.points.size(); ++i) {
    if (cell.is_observed[i]) continue;
    const double distance = (cell.points[i] - end).norm();
    if (distance <= reach_) {
      cell.is_observed[i] = true;
      --cell.open;
    } else if (distance <= reach_ + diagonal) {
      leaves_more = true;
    }
  }
  return leaves_more;
}

bool ObservedSurface::is_observed(const Eigen::Vector3d& p_map) const {
  const auto key = cells_.key(p_map);
  const auto cell = key ? cell_of_.find(key->bits()) : cell_of_.end();
  if (cell == cell_of_.end()) return false;
  const Points& points = cell->second.points;
  const auto found = std::lower_bound(points.begin(), points.end(), p_map, is_before);
  return found != points.end() && *found == p_map &&
         cell->second.is_observed[static_cast<std::size_t>(found - points.begin())];
}

std::size_t ObservedSurface::memory_bytes() const {
  constexpr std::size_t kNode = 2 * sizeof(void*);  // of a hash table, beside the value
  std::size_t bytes = sizeof(*this) + taken_cubes_.size() * (kNode + sizeof(std::uint64_t)) +
                      (taken_cubes_.bucket_count() + cell_of_.bucket_count()) * sizeof(void*);
  for (const auto& [key, cell] : cell_of_) {
    bytes += kNode + sizeof(key) + sizeof(cell) + cell.points.capacity() * sizeof(Eigen::Vector3d) +
             cell.is_observed.capacity() / 8;
  }
  return bytes;
}

}  // namespace evermap
