// SPDX-FileCopyrightText: 2026 the evermap authors
// SPDX-License-Identifier: BSD-3-Clause
#include "experiments/metrics.hpp"

#include <algorithm>
#include <cmath>
#include <string>
#include <utility>
#include <vector>

namespace evermap {
namespace {

/// The map's points in the area; of very many, each so many one: a fraction of 250,000 is known to 0.001.
Points sampled(const Points& whole, const Eigen::AlignedBox2d& area) {
  constexpr std::size_t kMost = 250'000;
  const Points map = within(area, whole);
  const std::size_t step = map.size() / kMost + 1;
  Points sample;
  for (std::size_t i = 0; i < map.size(); i += step) sample.push_back(map[i]);
  return sample;
}

SurfaceComparison compare(const Points& map, const Points& truth_points, const Truth& truth,
                          const Eigen::AlignedBox2d& area) {
  return {nearest_distances(truth_points, map), truth.distances(sampled(map, area))};
}

/// Cells of one picture, row by row from the north.
class Cells {
 public:
  explicit Cells(const Eigen::AlignedBox2d& view)
      : view_(view),
        columns_(static_cast<std::size_t>(std::ceil(view.sizes().x() / kCellEdge))),
        rows_(static_cast<std::size_t>(std::ceil(view.sizes().y() / kCellEdge))),
        seen_(columns_ * rows_, 0),
        missing_(columns_ * rows_, 0),
        is_ghost_(columns_ * rows_, false) {}

  void add_truth(const Eigen::Vector3d& p_map, bool is_missing) {
    if (!view_.contains(p_map.head<2>())) return;
    ++seen_[cell(p_map)];
    missing_[cell(p_map)] += is_missing ? 1 : 0;
  }
  void add_ghost(const Eigen::Vector3d& p_map) {
    if (view_.contains(p_map.head<2>())) is_ghost_[cell(p_map)] = true;
  }

  Json rows() const {
    Json rows = Json::array();
    for (std::size_t row = 0; row < rows_; ++row) {
      std::string text;
      for (std::size_t i = row * columns_; i < (row + 1) * columns_; ++i) text += static_cast<char>(kind(i));
      rows.push_back(std::move(text));
    }
    return rows;
  }

 private:
  std::size_t cell(const Eigen::Vector3d& p_map) const {
    const auto column = static_cast<std::size_t>((p_map.x() - view_.min().x()) / kCellEdge);
    const auto row = static_cast<std::size_t>((view_.max().y() - p_map.y()) / kCellEdge);
    return std::min(row, rows_ - 1) * columns_ + std::min(column, columns_ - 1);
  }
  Cell kind(std::size_t cell) const {
    if (is_ghost_[cell]) return Cell::kGhost;
    if (seen_[cell] == 0) return Cell::kNothing;
    return 2 * missing_[cell] > seen_[cell] ? Cell::kHole : Cell::kKept;
  }

  Eigen::AlignedBox2d view_;
  std::size_t columns_, rows_;
  std::vector<int> seen_, missing_;  ///< true points of each cell, and those that the map lacks
  std::vector<bool> is_ghost_;
};

}  // namespace

Json measure_surface(const Points& map, const Truth& truth, const Eigen::AlignedBox2d& area, double leaf) {
  const SurfaceComparison surface = compare(map, truth.observed, truth, area);
  Json row;
  const std::vector<std::pair<std::string, double>> tolerances{
      {"0.1", 0.1}, {"0.2", 0.2}, {"0.5", 0.5}, {"l/2", leaf / 2}, {"l", leaf}};
  for (const auto& [name, tolerance] : tolerances) row["COV " + name] = surface.coverage(tolerance);
  for (const auto& [name, tolerance] : tolerances) row["ACC " + name] = surface.accuracy(tolerance);
  row["truth to map"] = surface.mean_truth_to_map();
  row["map to truth"] = surface.mean_map_to_truth();
  row["AHD"] = surface.average_hausdorff_distance();
  return row;
}

Json measure_uncropped(const Points& map, const Truth& truth, const Eigen::AlignedBox2d& area) {
  const SurfaceComparison surface = compare(map, truth.surface, truth, area);
  return {{"uncropped COV 0.2", surface.coverage(0.2)},
          {"uncropped AHD", surface.average_hausdorff_distance()}};
}

Json measure_changes(const Mapper& mapper, const Changes& changes, double position_sigma) {
  const auto is_claimed = [&](const Eigen::Vector3d& p_map) { return mapper.claims(p_map, position_sigma); };
  const double kept = fraction_true(changes.unchanged, is_claimed);
  const double erased = 1 - fraction_true(changes.removed, is_claimed);
  return {{"SA", kept},
          {"DA", erased},
          {"AA", associated_accuracy(kept, erased)},
          {"HA", harmonic_accuracy(kept, erased)}};
}

Json seen_from_above(const Points& map, const Truth& truth, const Eigen::AlignedBox2d& view, double leaf) {
  const Points shown = within(view, map);
  const Points observed = within(view, truth.observed);
  const std::vector<double> to_map = nearest_distances(observed, shown);
  const std::vector<double> to_truth = truth.distances(shown);
  Cells cells(view);
  for (std::size_t i = 0; i < observed.size(); ++i) cells.add_truth(observed[i], to_map[i] > leaf);
  for (std::size_t i = 0; i < shown.size(); ++i) {
    if (to_truth[i] > leaf) cells.add_ghost(shown[i]);
  }
  return cells.rows();
}

}  // namespace evermap
