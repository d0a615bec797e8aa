// SPDX-FileCopyrightText: 2026 the evermap authors
// SPDX-License-Identifier: BSD-3-Clause
#include <algorithm>
#include <stdexcept>

#include <evermap/evaluation/bonxai_baseline.hpp>
#include <evermap/evaluation/evermap_mapper.hpp>
#include <evermap/evaluation/mapper.hpp>
#include <evermap/evaluation/octomap_baseline.hpp>
#include <evermap/evaluation/ufomap_baseline.hpp>

namespace evermap {
namespace {

/// The points [m, map frame] of a scan that a grid is fed.
using Feed = std::function<Points(const Scan&, const Pose& T_map_sensor)>;

Feed all_points(const LidarParameters& lidar) {
  return [lidar](const Scan& scan, const Pose& T_map_sensor) {
    Points p_map;
    p_map.reserve(scan.p_sensor.size());
    for (const Eigen::Vector3d& p_sensor : scan.p_sensor) {
      const double range = p_sensor.norm();
      if (range >= lidar.min_range && range <= lidar.max_range) p_map.push_back(T_map_sensor * p_sensor);
    }
    return p_map;
  };
}

Feed voxel_means(double edge, const LidarParameters& lidar) {
  return [edge, lidar](const Scan& scan, const Pose& T_map_sensor) {
    const BundleGrid grid = condense(scan, T_map_sensor, VoxelGrid{.edge = edge}, lidar);
    Points p_map;
    for (const RayBundle& bundle : grid.bundles()) p_map.push_back(bundle.points.mean);
    return p_map;
  };
}

/// An occupancy grid: OctoMapBaseline or what has the same members.
template <class Grid>
class GridMapper final : public Mapper {
 public:
  GridMapper(std::string name, double edge, Feed feed)
      : Mapper(std::move(name)), grid_(edge), feed_(std::move(feed)) {}

  std::string version() const override { return Grid::version(); }
  void start(const Points& survey_map, const Pose& /*T_map_sensor_initial*/) override {
    grid_.insert_surface(survey_map);
  }
  std::function<void()> prepare(const Scan& scan, const Pose& T_map_sensor) override {
    return grid_.prepare_scan(T_map_sensor.translation, feed_(scan, T_map_sensor));
  }
  bool claims(const Eigen::Vector3d& p_map, double /*position_sigma*/) const override {
    return grid_.occupied(p_map);
  }
  Points surface() const override { return grid_.occupied_centers(); }
  std::size_t memory_bytes() const override { return grid_.memory_bytes(); }

 private:
  Grid grid_;
  Feed feed_;
};

using Maker = std::unique_ptr<Mapper> (*)(const std::string& name, double edge, const LidarParameters& lidar);

std::unique_ptr<Mapper> make_evermap(const std::string& name, double edge, const LidarParameters& lidar,
                                     const UpdateParameters& update, MapMode mode) {
  return std::make_unique<EvermapMapper>(name, edge, Parameters{lidar, update, {}, {}}, mode);
}

std::unique_ptr<Mapper> make_static(const std::string& name, double edge, const LidarParameters& lidar) {
  return make_evermap(name, edge, lidar, UpdateParameters{}, MapMode::kLocalization);
}

/// A grid that is fed all points.
template <class Grid>
std::unique_ptr<Mapper> make_grid(const std::string& name, double edge, const LidarParameters& lidar) {
  return std::make_unique<GridMapper<Grid>>(name, edge, all_points(lidar));
}

/// In place of a mapper whose library was not found.
[[maybe_unused]] std::unique_ptr<Mapper> make_none(const std::string& /*name*/, double /*edge*/,
                                                   const LidarParameters& /*lidar*/) {
  return nullptr;
}

#ifdef EVERMAP_UFOMAP_VERSION
constexpr Maker kMakeUfoMap = make_grid<UfoMapBaseline>;
#else
constexpr Maker kMakeUfoMap = make_none;
#endif
#ifdef EVERMAP_HAS_BONXAI
constexpr Maker kMakeBonxai = make_grid<BonxaiBaseline>;
#else
constexpr Maker kMakeBonxai = make_none;
#endif

std::unique_ptr<Mapper> make_octomap_of_means(const std::string& name, double edge,
                                              const LidarParameters& lidar) {
  return std::make_unique<GridMapper<OctoMapBaseline>>(name, edge, voxel_means(edge, lidar));
}

std::unique_ptr<Mapper> make_paper(const std::string& name, double edge, const LidarParameters& lidar) {
  return make_evermap(name, edge, lidar, UpdateParameters::paper(), MapMode::kMaintenance);
}

std::unique_ptr<Mapper> make_default(const std::string& name, double edge, const LidarParameters& lidar) {
  return make_evermap(name, edge, lidar, UpdateParameters{}, MapMode::kMaintenance);
}

const std::vector<std::pair<std::string, Maker>>& makers() {
  static const std::vector<std::pair<std::string, Maker>> list{
      {"static map", make_static},
      {"OctoMap", make_grid<OctoMapBaseline>},
      {"OctoMap, voxel means", make_octomap_of_means},
      {"UFOMap", kMakeUfoMap},
      {"Bonxai", kMakeBonxai},
      {"evermap paper", make_paper},
      {"evermap default", make_default},
  };
  return list;
}

}  // namespace

const std::vector<std::string>& mapper_names() {
  static const std::vector<std::string> names = [] {
    std::vector<std::string> list;
    for (const auto& [name, make] : makers()) list.push_back(name);
    return list;
  }();
  return names;
}

std::unique_ptr<Mapper> make_mapper(std::string_view name, double edge, const LidarParameters& lidar) {
  for (const auto& [known, make] : makers()) {
    if (known == name) return make(known, edge, lidar);
  }
  std::string message = "no mapper is named \"" + std::string(name) + "\"; there are";
  for (const std::string& known : mapper_names()) message += " \"" + known + "\"";
  throw std::invalid_argument(message);
}

}  // namespace evermap
