// SPDX-FileCopyrightText: 2026 the evermap authors
// SPDX-License-Identifier: BSD-3-Clause
#include <algorithm>
#include <cmath>
#include <utility>

#include <evermap/files/file_error.hpp>
#include <evermap/simulation/noise.hpp>
#include <evermap/simulation/scenario_drive.hpp>
#include <evermap/simulation/surface_index.hpp>
#include <evermap/simulation/terrain.hpp>

namespace evermap {
namespace {

constexpr int kGround = 0;
constexpr int kSolidsPerObject = 64;
constexpr double kRobotReach = 0.75;  ///< [m] from the robot's middle to its wheels

/// Adds what one object is at one time to a scene.
class ObjectBuilder {
 public:
  ObjectBuilder(Scene& scene, const HeightFunction& ground, int object)
      : scene_(scene), ground_(ground), object_(object), solid_(object * kSolidsPerObject) {}

  void add(const ObjectState& state, double time) {
    const std::optional<Place> place = state.where.at(time);
    if (!place) return;
    std::visit([&](const auto& shape) { add(shape, state, *place, time); }, state.shape);
  }

 private:
  void add(const Body& body, const ObjectState& state, const Place& place, double) {
    const Pose T_map_body = standing(state, place);
    for (std::size_t i = 0; i < body.size(); ++i) {
      add_box(scene_, solid_ + static_cast<int>(i), T_map_body * body[i].T_body_box, body[i].size);
    }
  }
  void add(const HeapShape& heap, const ObjectState&, const Place& place, double time) {
    const double height = heap.height.at(time);
    if (height > 0) add_heap(scene_, solid_, {place.xy, heap.radius, height}, ground_);
  }
  void add(const PileShape& pile, const ObjectState&, const Place& place, double time) {
    const double height = pile.height.at(time);
    const auto seed = static_cast<std::uint64_t>(object_);
    if (height > 0) add_pile(scene_, solid_, {place.xy, height, pile.repose, pile.roughness, seed}, ground_);
  }
  void add(const TriangleMesh& mesh, const ObjectState& state, const Place& place, double) {
    add_mesh(scene_, solid_, standing(state, place), mesh);
  }

  Pose standing(const ObjectState& state, const Place& place) const {
    constexpr double kReach = 1;  ///< [m] from a body's middle to its feet, about
    Pose T_map_stand;
    if (state.is_tilted) {
      T_map_stand = standing_pose(ground_, place, kReach);
    } else {
      T_map_stand.rotation = Eigen::AngleAxisd(place.yaw, Eigen::Vector3d::UnitZ()).toRotationMatrix();
      T_map_stand.translation << place.xy, ground_(place.xy.x(), place.xy.y());
    }
    T_map_stand.translation.z() += state.lift;
    return T_map_stand;
  }

  Scene& scene_;
  const HeightFunction& ground_;
  int object_;
  int solid_;
};

/// Adds those objects that have the wanted state: `state_of` gives a pointer to it, or none.
template <class StateOf>
void add_objects(Scene& scene, const Scenario& scenario, double time, const StateOf& state_of) {
  for (std::size_t i = 0; i < scenario.objects.size(); ++i) {
    const ObjectState* state = state_of(scenario.objects[i]);
    if (state != nullptr) {
      ObjectBuilder(scene, scenario.ground, static_cast<int>(i) + 1).add(*state, time);
    }
  }
}

const ObjectState* state_in_run(const ScenarioObject& object, bool changes) {
  return object.run && object.run->changes() == changes ? &*object.run : nullptr;
}

Scene unchanging_scene(const Scenario& scenario) {
  Scene scene;
  add_ground(scene, kGround, scenario.area, scenario.ground_spacing, scenario.ground);
  add_objects(scene, scenario, 0, [](const ScenarioObject& o) { return state_in_run(o, false); });
  return scene;
}

/// Share of the beams that come back from a surface. The light that returns falls with the square of the
/// range and with the cosine of the incidence; at `dropout_range` a white wall, met squarely, gives 1/2.
double share_returned(double dropout_range, double reflectivity, const RayCaster::Hit& hit) {
  const double relative = dropout_range / hit.range;
  const double light = reflectivity * hit.cosine * relative * relative;
  return light > 0 ? std::exp2(-1 / (light * light)) : 0;
}

std::optional<RayCaster::Hit> nearest(const RayCaster& one, const RayCaster& other,
                                      const Eigen::Vector3d& origin, const Eigen::Vector3d& direction,
                                      double max_range) {
  const auto hit = one.first_hit(origin, direction, max_range);
  const auto nearer = other.first_hit(origin, direction, hit ? hit->range : max_range);
  return nearer ? nearer : hit;
}

void append(Scene& scene, const Scene& other) {
  const auto first = static_cast<std::uint32_t>(scene.vertices.size());
  scene.vertices.insert(scene.vertices.end(), other.vertices.begin(), other.vertices.end());
  for (const auto& [a, b, c] : other.triangles) scene.triangles.push_back({first + a, first + b, first + c});
  scene.object.insert(scene.object.end(), other.object.begin(), other.object.end());
}

}  // namespace

ScenarioDrive::ScenarioDrive(Scenario scenario)
    : scenario_(std::move(scenario)),
      unchanging_(unchanging_scene(scenario_)),
      unchanging_rays_(unchanging_) {
  check_sensor_is_free();
}

int ScenarioDrive::object_of(int solid) { return solid / kSolidsPerObject; }

double ScenarioDrive::time(std::size_t index) const {
  return (static_cast<double>(index) + 1) / scenario_.lidar.rate;
}

Pose ScenarioDrive::T_map_sensor_at(double time) const {
  Pose T_robot_sensor;
  T_robot_sensor.translation.z() = scenario_.sensor_height;
  return standing_pose(scenario_.ground, scenario_.robot.at(time).value(), kRobotReach) * T_robot_sensor;
}

Pose ScenarioDrive::pose_in_scan(std::size_t index, double offset) const {
  return T_map_sensor_at(time(index) - 1 / scenario_.lidar.rate + offset);
}

LabelledScan ScenarioDrive::scan(std::size_t index) const {
  const LidarModel& lidar = scenario_.lidar;
  const RayCaster changing_rays(changing_scene(time(index)));
  const std::uint64_t range_seed = hash_bits(scenario_.seed) + index;
  const std::uint64_t dropout_seed = hash_bits(range_seed);
  Pose T_map_sensor = this->T_map_sensor(index);
  LabelledScan result;
  for (int beam = 0; beam < lidar.beams(); ++beam) {
    const int column = beam / lidar.channels;
    const double offset = column / (lidar.columns * lidar.rate);
    if (scenario_.motion_distortion && beam % lidar.channels == 0) {
      T_map_sensor = pose_in_scan(index, offset);
    }
    const Eigen::Vector3d p_beam = lidar.direction(beam);
    const auto hit = nearest(unchanging_rays_, changing_rays, T_map_sensor.translation,
                             T_map_sensor.rotation * p_beam, lidar.max_range);
    if (!hit || hit->range < lidar.min_range) continue;
    const int object = object_of(hit->object);
    const auto number = static_cast<std::uint64_t>(beam);
    const double returned =
        scenario_.dropout_range ? share_returned(*scenario_.dropout_range, reflectivity_of(object), *hit) : 1;
    if (uniform(dropout_seed, number) > returned) continue;
    const double range = hit->range + lidar.range_sigma * standard_normal(range_seed, number);
    if (range <= 0) continue;
    result.scan.p_sensor.emplace_back(range * p_beam);
    if (scenario_.motion_distortion) result.scan.time_offset.push_back(static_cast<float>(offset));
    result.object.push_back(object);
  }
  return result;
}

std::vector<Eigen::Vector3d> ScenarioDrive::in_map(std::size_t index, const Scan& scan) const {
  std::vector<Eigen::Vector3d> p_map;
  p_map.reserve(scan.p_sensor.size());
  Pose T_map_sensor = this->T_map_sensor(index);
  for (std::size_t i = 0; i < scan.p_sensor.size(); ++i) {
    const bool is_new_column =
        !scan.time_offset.empty() && (i == 0 || scan.time_offset[i] != scan.time_offset[i - 1]);
    if (is_new_column) T_map_sensor = pose_in_scan(index, double{scan.time_offset[i]});
    p_map.emplace_back(T_map_sensor * scan.p_sensor[i]);
  }
  return p_map;
}

std::vector<SurfaceSample> ScenarioDrive::samples_of(const Scene& scene, double spacing) const {
  constexpr double kMostSamples = 3e7;  // 1 GB
  double area = 0;
  for (std::size_t i = 0; i < scene.triangles.size(); ++i) {
    area += scene.triangle(i).scaled_normal().norm() / 2;
  }
  const double samples = area / (spacing * spacing);
  if (!(samples <= kMostSamples)) {
    throw FileError(scenario_.source,
                    "its surfaces would take more than 30 million points at this spacing; "
                    "make the world smaller or flatter, or the spacing wider");
  }
  return sample_surface(scene, spacing);
}

std::vector<Eigen::Vector3d> ScenarioDrive::survey(double spacing) const {
  std::vector<Eigen::Vector3d> points;
  for (const SurfaceSample& sample : samples_of(survey_scene(), spacing)) points.push_back(sample.p_map);
  return points;
}

std::vector<SurfaceSample> ScenarioDrive::truth(std::size_t index, double spacing) const {
  std::vector<SurfaceSample> samples = samples_of(scene(index), spacing);
  for (SurfaceSample& sample : samples) sample.object = object_of(sample.object);
  return samples;
}

Scene ScenarioDrive::survey_scene() const {
  Scene scene;
  add_ground(scene, kGround, scenario_.area, scenario_.ground_spacing, scenario_.ground);
  add_objects(scene, scenario_, 0, [](const ScenarioObject& o) { return o.survey ? &*o.survey : nullptr; });
  return scene;
}

Scene ScenarioDrive::scene(std::size_t index) const {
  Scene scene = unchanging_;
  append(scene, changing_scene(time(index)));
  return scene;
}

Scene ScenarioDrive::settled_scene(std::size_t index) const {
  Scene all = scene(index);
  Scene settled{std::move(all.vertices), {}, {}};
  for (std::size_t i = 0; i < all.triangles.size(); ++i) {
    if (class_of(object_of(all.object[i])) == ObjectClass::kHighDynamic) continue;
    settled.triangles.push_back(all.triangles[i]);
    settled.object.push_back(all.object[i]);
  }
  return settled;
}

Scene ScenarioDrive::changing_scene(double time) const {
  Scene scene;
  add_objects(scene, scenario_, time, [](const ScenarioObject& o) { return state_in_run(o, true); });
  return scene;
}

ObjectClass ScenarioDrive::class_of(int object) const {
  return object == kGround ? ObjectClass::kStatic
                           : scenario_.objects[static_cast<std::size_t>(object) - 1].object_class;
}

std::string ScenarioDrive::name_of(int object) const {
  return object == kGround ? "ground" : scenario_.objects[static_cast<std::size_t>(object) - 1].name;
}

double ScenarioDrive::reflectivity_of(int object) const {
  return object == kGround ? scenario_.ground_reflectivity
                           : scenario_.objects[static_cast<std::size_t>(object) - 1].reflectivity;
}

void ScenarioDrive::check_sensor_is_free() const {
  const SurfaceIndex unchanging(unchanging_);
  for (std::size_t i = 0; i < size(); ++i) {
    const Eigen::Vector3d p_map = T_map_sensor(i).translation;
    const std::string at_scan = " at scan " + std::to_string(i);
    if (!scenario_.area.contains(p_map.head<2>())) {
      throw FileError::at_line(scenario_.source, scenario_.robot_line,
                               "the robot leaves the ground's area" + at_scan);
    }
    const Scene changing = changing_scene(time(i));
    if (!unchanging.buried(p_map) && !SurfaceIndex(changing).buried(p_map)) continue;
    for (std::size_t k = 0; k < scenario_.objects.size(); ++k) {
      const ScenarioObject& object = scenario_.objects[k];
      Scene alone;
      if (object.run)
        ObjectBuilder(alone, scenario_.ground, static_cast<int>(k) + 1).add(*object.run, time(i));
      if (!SurfaceIndex(alone).buried(p_map)) continue;
      throw FileError::at_line(scenario_.source, object.line, object.name + " contains the sensor" + at_scan);
    }
    throw FileError::at_line(scenario_.source, scenario_.robot_line,
                             "the ground contains the sensor" + at_scan);
  }
}

}  // namespace evermap
