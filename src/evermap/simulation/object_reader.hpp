// SPDX-FileCopyrightText: 2026 the evermap authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstddef>
#include <filesystem>
#include <map>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include <evermap/files/detail/yaml_value.hpp>
#include <evermap/simulation/scenario.hpp>

namespace evermap {

using Bodies = std::map<std::string, Body>;

/// Bodies by name, see docs/scenarios.md.
Bodies read_bodies(const YamlValue& value);

/// Where a robot or an object is: the keys `at` and `route`.
Whereabouts read_whereabouts(const YamlMap& map);

/// The triangles of an object's meshes, in the run and in the survey.
std::size_t mesh_triangles(const ScenarioObject& object);

/// Reads the entries of `objects`. One that stands at several places becomes as many objects.
class ObjectReader {
 public:
  // What a scenario may ask for, see docs/scenarios.md.
  static constexpr std::size_t kMostObjects = 1000;
  static constexpr std::size_t kMostTriangles = 4'000'000;  ///< of all meshes

  /// Mesh files are looked for in `folder`.
  ObjectReader(Bodies bodies, std::filesystem::path folder)
      : bodies_(std::move(bodies)), folder_(std::move(folder)) {}

  std::vector<ScenarioObject> read(const YamlValue& value) const;

 private:
  ScenarioObject read_object(const YamlMap& map) const;
  std::optional<ObjectState> read_survey(const YamlMap& map, const YamlValue& survey) const;
  ObjectState read_state(const YamlMap& map) const;
  Shape read_shape(const YamlMap& map) const;
  Body read_body(const YamlValue& value) const;
  TriangleMesh read_mesh_of(const YamlValue& value) const;

  Bodies bodies_;
  std::filesystem::path folder_;
};

}  // namespace evermap
