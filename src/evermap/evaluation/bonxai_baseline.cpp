// SPDX-FileCopyrightText: 2026 the evermap authors
// SPDX-License-Identifier: BSD-3-Clause
#include <bonxai_map/probabilistic_map.hpp>
#include <cstdint>
#include <limits>
#include <utility>

#include <evermap/evaluation/bonxai_baseline.hpp>

namespace evermap {

struct BonxaiBaseline::Map : Bonxai::ProbabilisticMap {
  using Bonxai::ProbabilisticMap::ProbabilisticMap;
};

BonxaiBaseline::BonxaiBaseline(double edge) : edge_(edge), map_(std::make_unique<Map>(edge)) {}
BonxaiBaseline::~BonxaiBaseline() = default;
BonxaiBaseline::BonxaiBaseline(BonxaiBaseline&&) noexcept = default;
BonxaiBaseline& BonxaiBaseline::operator=(BonxaiBaseline&&) noexcept = default;

void BonxaiBaseline::insert_surface(const Points& points_map) {
  Map::CellT occupied;
  constexpr std::int32_t kBits = (1 << 27) - 1;  // that its bit field has for what is above 0
  occupied.probability_log = map_->options().clamp_max_log & kBits;
  auto& grid = map_->grid();
  auto accessor = grid.createAccessor();
  for (const Eigen::Vector3d& p_map : points_map) accessor.setValue(grid.posToCoord(p_map), occupied);
}

std::function<void()> BonxaiBaseline::prepare_scan(const Eigen::Vector3d& origin_map,
                                                   const Points& points_map) {
  return [&map = *map_, origin_map, points_map] {
    map.insertPointCloud(points_map, origin_map, std::numeric_limits<double>::infinity());
  };
}

bool BonxaiBaseline::occupied(const Eigen::Vector3d& p_map) const {
  // ProbabilisticMap::isOccupied keeps what it found last, so that it cannot be asked by several threads.
  const auto& grid = std::as_const(*map_).grid();
  const Map::CellT* cell = grid.createConstAccessor().value(grid.posToCoord(p_map));
  return cell != nullptr && cell->probability_log > map_->options().occupancy_threshold_log;
}

Points BonxaiBaseline::occupied_centers() const {
  Points centers;
  map_->getOccupiedVoxels(centers);  // their lower corners
  for (Eigen::Vector3d& center : centers) center.array() += 0.5 * edge_;
  return centers;
}

std::size_t BonxaiBaseline::memory_bytes() const { return map_->grid().memUsage(); }

}  // namespace evermap
