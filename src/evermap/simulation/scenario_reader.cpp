// SPDX-FileCopyrightText: 2026 the evermap authors
// SPDX-License-Identifier: BSD-3-Clause
#include <algorithm>
#include <cmath>
#include <limits>

#include <evermap/files/detail/input_file.hpp>
#include <evermap/files/detail/yaml_value.hpp>
#include <evermap/geometry/detail/degree.hpp>
#include <evermap/simulation/object_reader.hpp>
#include <evermap/simulation/scenario.hpp>
#include <evermap/simulation/shipped.hpp>
#include <evermap/simulation/terrain.hpp>

namespace evermap {
namespace {

constexpr std::string_view kBodies = "bodies";  ///< the shipped text that is no scenario

HeightFunction read_waves(const YamlMap& map) {
  const auto length = map.find("length");
  Waves result{map.number("amplitude", Limits::any()), Eigen::Vector2d::Constant(INFINITY),
               map.number("phase", Limits::any(), 0)};
  if (!length) map.get("length");
  const std::vector<double> along = length->numbers(1, 2, Limits::positive());
  std::copy(along.begin(), along.end(), result.length.data());
  return waves(result);
}

HeightFunction read_roughness(const YamlMap& map) {
  const auto seed = map.find("seed");
  return roughness({map.number("amplitude", Limits::not_negative()), map.number("size", Limits::positive()),
                    seed ? seed->natural() : 1});
}

HeightFunction read_terraces(const YamlMap& map) {
  const Terraces pit{map.get("center").vector2(Limits::any()),
                     map.get("size").vector2(Limits::positive()),
                     map.number("corner", Limits::not_negative(), 0),
                     map.get("count").whole(1, 100),
                     map.number("height", Limits::any()),
                     map.number("face", Limits::positive()),
                     map.number("width", Limits::not_negative()),
                     map.number("wobble", Limits::not_negative(), 0)};
  if (pit.corner > pit.size.minCoeff() / 2) map.get("corner").fail("corner is more than half of size");
  return terraces(pit);
}

HeightFunction read_embankment(const YamlMap& map) {
  Embankment bank{{},
                  map.number("height", Limits::any()),
                  map.number("width", Limits::not_negative()),
                  map.number("side", Limits::positive())};
  const YamlValue line = map.get("line");
  for (const YamlValue& item : line.list()) {
    bank.line.push_back(item.vector2(Limits::any()));
    const std::size_t n = bank.line.size();
    if (n > 1 && bank.line[n - 1] == bank.line[n - 2])
      item.fail("two points of a line are at the same place");
  }
  if (bank.line.size() < 2) line.fail("a line needs at least two points");
  return embankment(bank);
}

HeightFunction read_feature(const YamlValue& value) {
  const YamlMap map = value.map();
  if (map.values().size() != 1) value.fail("a feature is one of slope waves roughness terraces embankment");
  const YamlValue& feature = map.values().front();
  if (feature.key() == "slope") return slope(feature.vector2(Limits::any()));
  const auto read = [&](HeightFunction (*of)(const YamlMap&)) {
    const YamlMap keys = feature.map();
    HeightFunction height = of(keys);
    keys.refuse_unknown();
    return height;
  };
  if (feature.key() == "waves") return read(read_waves);
  if (feature.key() == "roughness") return read(read_roughness);
  if (feature.key() == "terraces") return read(read_terraces);
  if (feature.key() == "embankment") return read(read_embankment);
  feature.fail("unknown feature " + feature.key() + "; there are slope waves roughness terraces embankment");
}

void read_ground(const YamlMap& map, Scenario& scenario) {
  constexpr double kMostCells = 4e6;  ///< 0.5 GB of triangles
  const YamlValue area = map.get("area");
  const Eigen::Vector4d bounds(area.numbers(4, 4, Limits::any()).data());
  scenario.area = {bounds.head<2>(), bounds.tail<2>()};
  if (scenario.area.isEmpty() || scenario.area.volume() == 0) {
    area.fail("area needs x and y of the lower, then of the upper corner");
  }
  scenario.ground_spacing = map.number("spacing", Limits::positive(), scenario.ground_spacing);
  if (scenario.area.volume() > kMostCells * scenario.ground_spacing * scenario.ground_spacing) {
    area.fail("area has too many squares of spacing; choose a wider spacing");
  }
  scenario.ground_reflectivity = map.number("reflectivity", {0.01, 1}, scenario.ground_reflectivity);
  std::vector<HeightFunction> features;
  if (const auto list = map.find("features")) {
    for (const YamlValue& item : list->list()) features.push_back(read_feature(item));
  }
  scenario.ground = sum(std::move(features));
  map.refuse_unknown();
}

void read_lidar(const YamlMap& map, Scenario& scenario) {
  LidarModel& lidar = scenario.lidar;
  if (const auto value = map.find("channels")) lidar.channels = value->whole(1, 1024);
  if (const auto value = map.find("columns")) lidar.columns = value->whole(1, 8192);
  if (const auto value = map.find("elevation")) {
    const Eigen::Vector2d range = kDegree * value->vector2({-90, 90});
    if (range.x() > range.y()) value->fail("elevation needs the lowest beam, then the topmost");
    lidar.elevation_min = range.x();
    lidar.elevation_max = range.y();
  }
  lidar.rate = map.number("rate", {0.01, 1000}, lidar.rate);
  lidar.max_range = map.number("max_range", Limits::positive(), lidar.max_range);
  lidar.min_range = map.number("min_range", {0.01, lidar.max_range}, lidar.min_range);
  lidar.range_sigma = map.number("range_sigma", Limits::not_negative(), lidar.range_sigma);
  if (const auto value = map.find("dropout_range"))
    scenario.dropout_range = value->number(Limits::positive());
  if (const auto value = map.find("motion_distortion")) scenario.motion_distortion = value->truth();
  map.refuse_unknown();
}

void read_robot(const YamlValue& value, Scenario& scenario) {
  const YamlMap map = value.map();
  scenario.robot_line = value.line();
  scenario.sensor_height = map.number("sensor_height", Limits::positive());
  scenario.robot = read_whereabouts(map);
  const bool vanishes = scenario.robot.route && !scenario.robot.route->at(1e9);
  if (vanishes) map.get("route").fail("a robot cannot vanish; end its route with stay or loop");
  map.refuse_unknown();
}

std::string_view shipped_text(std::string_view name) {
  for (const auto& [known, text] : shipped_texts()) {
    if (known == name) return text;
  }
  return {};
}

void read_objects(const YamlMap& map, const std::filesystem::path& folder, Scenario& scenario) {
  Bodies bodies = read_bodies(YamlValue::parse("bodies", std::string(shipped_text(kBodies))));
  if (const auto own = map.find("bodies")) {
    for (auto& [name, body] : read_bodies(*own)) bodies.insert_or_assign(name, body);
  }
  const ObjectReader reader(std::move(bodies), folder);
  std::map<std::string, int> lines;
  const auto list = map.find("objects");
  if (!list) return;
  std::size_t triangles = 0;
  for (const YamlValue& item : list->list()) {
    for (ScenarioObject& object : reader.read(item)) {
      triangles += mesh_triangles(object);
      if (triangles > ObjectReader::kMostTriangles)
        item.fail("the meshes up to here have more than 4 million triangles");
      if (scenario.objects.size() == ObjectReader::kMostObjects)
        item.fail("there are more than 1000 objects");
      const auto [first, is_new] = lines.emplace(object.name, object.line);
      if (!is_new)
        item.fail("there is an object " + object.name + " already, at line " + std::to_string(first->second));
      scenario.objects.push_back(std::move(object));
    }
  }
}

}  // namespace

Scenario parse_scenario(const std::string& source, std::string text, const std::filesystem::path& folder) {
  Scenario scenario;
  scenario.source = source;
  scenario.text = std::move(text);
  const YamlMap map = YamlValue::parse(source, scenario.text).map();
  if (const auto value = map.find("seed")) scenario.seed = value->natural();
  scenario.scans = map.get("scans").whole(1, 1000000);
  if (const auto value = map.find("lidar")) read_lidar(value->map(), scenario);
  read_ground(map.get("ground").map(), scenario);
  read_robot(map.get("robot"), scenario);
  read_objects(map, folder, scenario);
  map.refuse_unknown();
  return scenario;
}

Scenario read_scenario(const std::filesystem::path& path) {
  const InputFile file(path);
  return parse_scenario(path.string(), std::string(file.bytes()), path.parent_path());
}

Scenario shipped_scenario(const std::string& name) {
  const std::string_view text = name == kBodies ? std::string_view() : shipped_text(name);
  if (!text.empty()) return parse_scenario(name, std::string(text));
  std::string known;
  for (const std::string& other : shipped_scenario_names()) known += " " + other;
  throw FileError(name, "is no shipped scenario; there are" + known);
}

std::vector<std::string> shipped_scenario_names() {
  std::vector<std::string> names;
  for (const auto& [name, text] : shipped_texts()) {
    if (name != kBodies) names.emplace_back(name);
  }
  return names;
}

}  // namespace evermap
