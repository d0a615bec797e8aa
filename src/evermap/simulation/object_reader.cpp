// SPDX-FileCopyrightText: 2026 the evermap authors
// SPDX-License-Identifier: BSD-3-Clause
#include <algorithm>
#include <array>
#include <cmath>
#include <optional>
#include <stdexcept>
#include <utility>

#include <evermap/geometry/detail/degree.hpp>
#include <evermap/simulation/mesh_file.hpp>
#include <evermap/simulation/object_reader.hpp>

namespace evermap {
namespace {

constexpr double kSink = 0.4;           ///< [m] that a box is let into the ground, for slopes
constexpr double kWallSink = 1.5;       ///< [m] the same for a wall, which is longer
constexpr std::size_t kMaxCount = 60;   ///< boxes of a body, see ScenarioDrive
constexpr double kMaxPileRadius = 100;  ///< [m] of a pile's foot

/// [m] The edges and heights of things.
Limits sizes() { return {1e-6, 1000}; }

Place read_place(const YamlValue& value) {
  const std::vector<double> numbers = value.numbers(2, 3, Limits::any());
  return {{numbers[0], numbers[1]}, numbers.size() > 2 ? numbers[2] * kDegree : 0};
}

Schedule read_schedule(const YamlValue& value) {
  if (!value.is_list()) return Schedule({{0, value.number(Limits::not_negative())}});
  std::vector<std::pair<double, double>> points;
  for (const YamlValue& item : value.list()) {
    const Eigen::Vector2d point = item.vector2(Limits::not_negative());
    if (!points.empty() && point.x() <= points.back().first) item.fail("the times of a height must increase");
    points.emplace_back(point.x(), point.y());
  }
  if (points.empty()) value.fail("a height over time needs at least one [time, height]");
  return Schedule(points);
}

Body upright_box(const Eigen::Vector3d& size, double sink) {
  BodyBox box{{size.x(), size.y(), size.z() + sink}, {}};
  box.T_body_box.translation.z() = (size.z() - sink) / 2;
  return {box};
}

BodyBox read_part(const YamlValue& value) {
  const YamlMap map = value.map();
  BodyBox part{map.get("size").vector3(sizes()), {}};
  const double yaw = map.number("yaw", Limits::any(), 0) * kDegree;
  const double pitch = map.number("pitch", {-90, 90}, 0) * kDegree;  // nose up
  part.T_body_box.rotation =
      (Eigen::AngleAxisd(yaw, Eigen::Vector3d::UnitZ()) * Eigen::AngleAxisd(-pitch, Eigen::Vector3d::UnitY()))
          .toRotationMatrix();
  const Eigen::Vector3d bottom_to_center(0, 0, part.size.z() / 2);
  part.T_body_box.translation =
      map.get("at").vector3(Limits::any()) + part.T_body_box.rotation * bottom_to_center;
  map.refuse_unknown();
  return part;
}

Body read_parts(const YamlValue& value) {
  Body body;
  for (const YamlValue& item : value.list()) body.push_back(read_part(item));
  if (body.empty()) value.fail(value.key() + " needs at least one box");
  if (body.size() > kMaxCount) value.fail(value.key() + " may have at most 60 boxes");
  return body;
}

Route::Waypoint read_waypoint(const YamlValue& value, double speed) {
  if (!value.is_map()) return {value.vector2(Limits::any()), speed};
  const YamlMap map = value.map();
  Route::Waypoint waypoint{map.get("at").vector2(Limits::any()),
                           map.number("speed", Limits::positive(), speed),
                           map.number("wait", Limits::not_negative(), 0)};
  map.refuse_unknown();
  return waypoint;
}

Route::End read_end(const YamlMap& map) {
  const std::optional<YamlValue> value = map.find("end");
  if (!value || value->text() == "stay") return Route::End::kStay;
  if (value->text() == "loop") return Route::End::kLoop;
  if (value->text() == "vanish") return Route::End::kVanish;
  value->fail("end needs one of stay loop vanish, not '" + value->text() + "'");
}

Route read_route(const YamlValue& value) {
  const YamlMap map = value.map();
  const double speed = map.number("speed", Limits::positive());
  const double turn_radius = map.number("turn_radius", Limits::not_negative(), 0);
  const double start = map.number("start", Limits::not_negative(), 0);
  const Route::End end = read_end(map);
  std::vector<Route::Waypoint> waypoints;
  for (const YamlValue& item : map.get("waypoints").list()) waypoints.push_back(read_waypoint(item, speed));
  map.refuse_unknown();
  try {
    return Route(std::move(waypoints), turn_radius, start, end);
  } catch (const std::invalid_argument& error) {
    map.get("waypoints").fail(error.what());
  }
}

HeapShape read_heap(const YamlValue& value) {
  const YamlMap map = value.map();
  HeapShape heap{map.number("radius", sizes()), read_schedule(map.get("height"))};
  map.refuse_unknown();
  return heap;
}

PileShape read_pile(const YamlValue& value) {
  constexpr Limits kRepose{5, 80};  ///< [degrees]
  const YamlMap map = value.map();
  PileShape pile{map.number("repose", kRepose, 35) * kDegree,
                 map.number("roughness", Limits::not_negative(), 0.05), read_schedule(map.get("height"))};
  map.refuse_unknown();
  if (pile.height.most() / std::tan(pile.repose) > kMaxPileRadius) {
    value.fail("a pile of this height and repose is wider than 200 m");
  }
  return pile;
}

Body read_post(const YamlValue& value) {
  const YamlMap map = value.map();
  const double width = map.number("width", sizes(), 0.2);
  const double height = map.number("height", sizes());
  map.refuse_unknown();
  return upright_box({width, width, height}, kSink);
}

/// A wall is the only shape that says itself where it is.
struct Wall {
  Body body;
  Place place;
};
Wall read_wall(const YamlValue& value) {
  const YamlMap map = value.map();
  const Eigen::Vector2d from = map.get("from").vector2(Limits::any());
  const Eigen::Vector2d to = map.get("to").vector2(Limits::any());
  const double height = map.number("height", sizes());
  const double thickness = map.number("thickness", sizes(), 0.3);
  const double sink = map.number("sink", Limits::not_negative(), kWallSink);
  map.refuse_unknown();
  const Eigen::Vector2d line = to - from;
  if (line.norm() == 0) value.fail("a wall's ends are at the same place");
  return {upright_box({line.norm(), thickness, height}, sink),
          {(from + to) / 2, std::atan2(line.y(), line.x())}};
}

ObjectClass read_class(const YamlValue& value) {
  const std::string name = value.text();
  if (name == "static") return ObjectClass::kStatic;
  if (name == "low_dynamic") return ObjectClass::kLowDynamic;
  if (name == "high_dynamic") return ObjectClass::kHighDynamic;
  value.fail("class needs one of static low_dynamic high_dynamic, not '" + name + "'");
}

bool is_heaped(const Shape& shape) {
  return std::holds_alternative<HeapShape>(shape) || std::holds_alternative<PileShape>(shape);
}

ObjectClass class_by_default(const ScenarioObject& object, bool is_as_surveyed) {
  if (object.run && object.run->where.route) return ObjectClass::kHighDynamic;
  if (!is_as_surveyed || (object.run && object.run->changes())) return ObjectClass::kLowDynamic;
  return ObjectClass::kStatic;
}

/// The places of an entry, one object for each; without `places`, the entry's own.
std::vector<std::optional<Place>> read_places(const YamlMap& map) {
  const std::optional<YamlValue> value = map.find("places");
  if (!value) return {std::nullopt};
  std::vector<std::optional<Place>> places;
  for (const YamlValue& item : value->list()) places.emplace_back(read_place(item));
  if (places.empty()) value->fail("places needs at least one place");
  if (places.size() > ObjectReader::kMostObjects) value->fail("there are more than 1000 objects");
  return places;
}

}  // namespace

std::size_t mesh_triangles(const ScenarioObject& object) {
  std::size_t triangles = 0;
  for (const auto* state : {&object.survey, &object.run}) {
    const auto* mesh = *state ? std::get_if<TriangleMesh>(&(*state)->shape) : nullptr;
    if (mesh != nullptr) triangles += mesh->triangles.size();
  }
  return triangles;
}

Bodies read_bodies(const YamlValue& value) {
  Bodies bodies;
  const YamlMap map = value.map();
  for (const YamlValue& body : map.values()) bodies.emplace(body.key(), read_parts(body));
  return bodies;
}

Whereabouts read_whereabouts(const YamlMap& map) {
  const std::optional<YamlValue> route = map.find("route");
  const std::optional<YamlValue> at = map.find("at");
  if (route && at) route->fail("give either at or route");
  if (route) return {{}, read_route(*route)};
  return {read_place(map.get("at")), {}};
}

Body ObjectReader::read_body(const YamlValue& value) const {
  if (value.is_list()) return read_parts(value);
  const auto found = bodies_.find(value.text());
  if (found == bodies_.end()) value.fail("there is no body " + value.text());
  return found->second;
}

TriangleMesh ObjectReader::read_mesh_of(const YamlValue& value) const {
  try {
    return read_mesh(folder_ / value.text());
  } catch (const FileError& error) {
    value.fail(error.what());
  }
}

Shape ObjectReader::read_shape(const YamlMap& map) const {
  if (const auto value = map.find("box")) {
    const double sink = map.number("sink", Limits::not_negative(), map.find("lift") ? 0 : kSink);
    return upright_box(value->vector3(sizes()), sink);
  }
  if (const auto value = map.find("post")) return read_post(*value);
  if (const auto value = map.find("body")) return read_body(*value);
  if (const auto value = map.find("heap")) return read_heap(*value);
  if (const auto value = map.find("pile")) return read_pile(*value);
  if (const auto value = map.find("mesh")) return read_mesh_of(*value);
  map.fail("an object needs one of box wall post body heap pile mesh");
}

ObjectState ObjectReader::read_state(const YamlMap& map) const {
  constexpr std::array kShapes = {"box", "wall", "post", "body", "heap", "pile", "mesh"};
  const auto shapes = std::count_if(kShapes.begin(), kShapes.end(),
                                    [&](const char* key) { return map.find(key).has_value(); });
  if (shapes > 1) map.fail("an object has one of box wall post body heap pile mesh");
  if (const auto value = map.find("wall")) {
    const Wall wall = read_wall(*value);
    return {wall.body, {wall.place, {}}};
  }
  ObjectState state{read_shape(map), map.find("places") ? Whereabouts{} : read_whereabouts(map)};
  state.is_tilted = map.find("body").has_value();
  if (!is_heaped(state.shape)) {
    state.lift = map.number("lift", Limits::any(), 0);
  } else if (state.where.route) {
    map.fail("a heap or pile has no route");
  }
  return state;
}

std::optional<ObjectState> ObjectReader::read_survey(const YamlMap& map, const YamlValue& survey) const {
  const YamlMap overrides = survey.map();
  for (const char* key : {"name", "class", "reflectivity", "survey", "places"}) {
    if (const auto found = overrides.find(key)) found->fail("a survey cannot change " + found->key());
  }
  const YamlMap merged = map.overridden(overrides);
  ObjectState state = read_state(merged);
  merged.refuse_unknown();
  return state;
}

ScenarioObject ObjectReader::read_object(const YamlMap& map) const {
  ScenarioObject object;
  object.line = map.line();
  object.name = map.get("name").text();
  object.reflectivity = map.number("reflectivity", {0.01, 1}, object.reflectivity);
  object.run = read_state(map);
  const std::optional<YamlValue> object_class = map.find("class");
  const std::optional<YamlValue> survey = map.find("survey");
  std::string then = object.run->where.route ? "absent" : "same";
  if (survey) then = survey->is_map() ? "other" : survey->text();
  if (then == "same" || then == "only") {
    object.survey = object.run;
  } else if (then == "other" && survey->is_map()) {
    map.find("places");
    object.survey = read_survey(map, *survey);
  } else if (then != "absent") {
    survey->fail("survey needs one of same absent only, or what was other then, not '" + then + "'");
  }
  if (then == "only") object.run.reset();
  object.object_class = object_class ? read_class(*object_class) : class_by_default(object, then == "same");
  return object;
}

std::vector<ScenarioObject> ObjectReader::read(const YamlValue& value) const {
  const YamlMap map = value.map();
  const ScenarioObject object = read_object(map);
  const auto places = read_places(map);
  map.refuse_unknown();
  if (places.size() * mesh_triangles(object) > kMostTriangles) {
    value.fail("its meshes have more than 4 million triangles");
  }
  std::vector<ScenarioObject> objects;
  for (const std::optional<Place>& place : places) {
    objects.push_back(object);
    if (!place) continue;
    objects.back().name += '/';
    objects.back().name += std::to_string(objects.size());
    for (auto* state : {&objects.back().survey, &objects.back().run}) {
      if (*state) (*state)->where.place = *place;
    }
  }
  return objects;
}

}  // namespace evermap
