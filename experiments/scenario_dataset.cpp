// SPDX-FileCopyrightText: 2026 the evermap authors
// SPDX-License-Identifier: BSD-3-Clause
#include "experiments/scenario_dataset.hpp"

#include <algorithm>
#include <map>
#include <utility>

#include <oneapi/tbb/parallel_for.h>

#include <evermap/geometry/voxel_key.hpp>
#include <evermap/simulation/change_truth.hpp>
#include <evermap/simulation/surface_index.hpp>

namespace evermap {
namespace {

/// A surface counts as observed where a ray ended in its voxel of this size.
const VoxelGrid kObserved{.edge = 0.2};

Scenario with_seed(Scenario scenario, std::uint64_t seed) {
  scenario.seed = seed;
  return scenario;
}

Scenario as_chosen(Scenario scenario, const ScenarioChoice& choice) {
  const int scans = choice.scans.value_or(scenario.scans);
  if (choice.stands_at_middle) {
    const double middle = 0.5 * std::min(scans, scenario.scans) / scenario.lidar.rate;
    scenario.robot = {scenario.robot.at(middle).value(), std::nullopt};
  }
  scenario.scans = scans;
  return scenario;
}

/// Distances to a scene, exact: samples of it tell how far to search.
class SceneDistances {
 public:
  SceneDistances(Scene scene, Points samples)
      : scene_(std::move(scene)), index_(scene_), samples_(std::move(samples)) {}

  std::vector<double> operator()(const Points& points) const {
    std::vector<double> distances = nearest_distances(points, samples_);
    oneapi::tbb::parallel_for(std::size_t{0}, points.size(), [&](std::size_t i) {
      constexpr double kSearched = 1.0;  // [m] beyond, the nearest sample is near enough
      if (distances[i] < kSearched)
        distances[i] = std::min(distances[i], index_.distance(points[i], distances[i]));
    });
    return distances;
  }

 private:
  Scene scene_;
  SurfaceIndex index_;
  Points samples_;
};

}  // namespace

ScenarioDataset::ScenarioDataset(const ScenarioChoice& choice, std::uint64_t seed)
    : ScenarioDataset(with_seed(shipped_scenario(choice.scenario), seed), choice) {}

ScenarioDataset::ScenarioDataset(Scenario scenario, ScenarioChoice choice)
    : choice_(std::move(choice)), drive_(as_chosen(std::move(scenario), choice_)) {
  const Scenario& driven = drive_.scenario();
  area = choice_.area.isEmpty() ? driven.area : choice_.area;
  view = choice_.view.isEmpty() ? area : choice_.view;
  lidar.range_sigma = driven.lidar.range_sigma;
  position_sigma = driven.lidar.range_sigma;

  std::vector<LabelledScan> labelled((drive_.size() + choice_.every - 1) / choice_.every);
  oneapi::tbb::parallel_for(std::size_t{0}, labelled.size(),
                            [&](std::size_t i) { labelled[i] = drive_.scan(number(i)); });
  for (std::size_t i = 0; i < labelled.size(); ++i) {
    scans_.push_back({std::move(labelled[i].scan), drive_.T_map_sensor(number(i))});
  }
  find_dynamic_objects(std::move(labelled));
  observed_ = observed_by(0);
}

void ScenarioDataset::find_dynamic_objects(std::vector<LabelledScan> labelled) {
  std::map<int, DynamicObject> objects;
  for (std::size_t i = 0; i < labelled.size(); ++i) {
    for (std::size_t k = 0; k < labelled[i].object.size(); ++k) {
      const int object = labelled[i].object[k];
      if (drive_.class_of(object) != ObjectClass::kHighDynamic) continue;
      DynamicObject& seen = objects[object];
      if (seen.p_map.empty()) seen = {drive_.name_of(object), std::vector<Points>(labelled.size())};
      seen.p_map[i].push_back(scans_[i].T_map_sensor * scans_[i].scan.p_sensor[k]);
    }
  }
  for (auto& [id, object] : objects) dynamic_objects_.push_back(std::move(object));
}

ScenarioDataset::Voxels ScenarioDataset::observed_by(std::size_t first_scan) const {
  Voxels voxels;
  for (std::size_t i = first_scan; i < scans_.size(); ++i) {
    for (const Eigen::Vector3d& p_sensor : scans_[i].scan.p_sensor) {
      if (const auto key = kObserved.key(scans_[i].T_map_sensor * p_sensor)) voxels.insert(key->bits());
    }
  }
  return voxels;
}

Truth ScenarioDataset::truth(std::size_t scan) const {
  Scene scene = drive_.settled_scene(number(scan));
  Truth truth;
  for (const SurfaceSample& sample : sample_surface(scene, choice_.truth_spacing)) {
    truth.surface.push_back(sample.p_map);
  }
  const auto distances = std::make_shared<SceneDistances>(std::move(scene), truth.surface);
  truth.distances = [distances](const Points& points) { return (*distances)(points); };
  truth.surface = within(area, truth.surface);
  for (const Eigen::Vector3d& p_map : truth.surface) {
    const auto key = kObserved.key(p_map);
    if (key && observed_.contains(key->bits())) truth.observed.push_back(p_map);
  }
  return truth;
}

Changes ScenarioDataset::changes(double leaf) const {
  const ChangeTruth change =
      change_truth(drive_.survey_scene(), drive_.settled_scene(number(scans_.size() - 1)),
                   choice_.truth_spacing, leaf / 2);
  const VoxelGrid grid{.edge = leaf};
  return {contradictable(within(area, change.unchanged), grid, rays()),
          contradictable(within(area, change.removed), grid, rays())};
}

Points ScenarioDataset::observed_lately(const std::string& prefix, std::size_t scans) const {
  const std::size_t lately = std::min(scans_.size(), (scans + choice_.every - 1) / choice_.every);
  const Voxels voxels = observed_by(scans_.size() - lately);
  Points points;
  for (const auto& [p_map, solid] :
       sample_surface(drive_.settled_scene(number(scans_.size() - 1)), choice_.truth_spacing / 2)) {
    const auto key = kObserved.key(p_map);
    if (!key || !voxels.contains(key->bits())) continue;
    if (drive_.name_of(ScenarioDrive::object_of(solid)).starts_with(prefix)) points.push_back(p_map);
  }
  return points;
}

}  // namespace evermap
