// SPDX-FileCopyrightText: 2026 the evermap authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <filesystem>
#include <optional>
#include <string>
#include <utility>
#include <variant>
#include <vector>

#include <Eigen/Core>
#include <Eigen/Geometry>

#include <evermap/geometry/pose.hpp>
#include <evermap/simulation/lidar_model.hpp>
#include <evermap/simulation/route.hpp>
#include <evermap/simulation/scene.hpp>

namespace evermap {

/// What becomes of an object, for whoever scores a map.
enum class ObjectClass : std::uint8_t {
  kStatic = 0,      ///< as it was in the survey
  kLowDynamic = 1,  ///< changed since the survey, or changes slowly
  kHighDynamic = 2  ///< moves
};

/// A height over time: linear between (time [s], height [m]), constant outside.
class Schedule {
 public:
  /// REQUIRES: not empty, times strictly increasing.
  explicit Schedule(std::vector<std::pair<double, double>> points) : points_(std::move(points)) {}

  double at(double time) const;
  double most() const;
  bool is_constant() const { return points_.size() == 1; }

 private:
  std::vector<std::pair<double, double>> points_;
};

/// A box whose center is the origin of its frame; the body's frame has x forward, z up and its origin on the
/// ground.
struct BodyBox {
  Eigen::Vector3d size;  ///< [m]
  Pose T_body_box;
};
using Body = std::vector<BodyBox>;

/// See Heap.
struct HeapShape {
  double radius;    ///< [m]
  Schedule height;  ///< [m]; 0: nothing
};
/// See Pile.
struct PileShape {
  double repose;     ///< [rad]
  double roughness;  ///< [m]
  Schedule height;   ///< [m]; 0: nothing
};
using Shape = std::variant<Body, HeapShape, PileShape, TriangleMesh>;

/// Where something is over time: at one place, or on a route.
struct Whereabouts {
  Place place;
  std::optional<Route> route;

  /// None when it is not there.
  std::optional<Place> at(double time) const { return route ? route->at(time) : std::optional(place); }
};

/// How an object is, during the run or in the survey.
struct ObjectState {
  Shape shape;
  Whereabouts where;
  double lift = 0;         ///< [m] of a body or mesh above the ground
  bool is_tilted = false;  ///< stands across the slope of the ground instead of upright

  bool changes() const;  ///< over time
};

struct ScenarioObject {
  std::string name;
  int line = 0;  ///< of the scenario's text
  ObjectClass object_class = ObjectClass::kStatic;
  double reflectivity = 0.4;          ///< (0, 1] share of the light that comes back
  std::optional<ObjectState> survey;  ///< none: was not there
  std::optional<ObjectState> run;     ///< none: is not there any more
};

/// A world that changes and a robot that drives through it; docs/scenarios.md describes the file.
struct Scenario {
  std::string source;  ///< path or name, for messages
  std::string text;    ///< as read

  std::uint64_t seed = 1;  ///< of the sensor's noise; the world does not depend on it
  int scans = 0;

  LidarModel lidar;
  std::optional<double> dropout_range;  ///< [m] at which half of the beams come back from a white wall
  bool motion_distortion = false;       ///< the sensor moves while it turns

  Eigen::AlignedBox2d area;     ///< [m] of the ground
  double ground_spacing = 0.5;  ///< [m]
  double ground_reflectivity = 0.4;
  HeightFunction ground;

  double sensor_height = 0;  ///< [m] above the ground
  Whereabouts robot;
  int robot_line = 0;

  std::vector<ScenarioObject> objects;  ///< ids are 1, 2, ... in this order; the ground is 0
};

/// From a text. Throws FileError naming `source` and the line of what is wrong. Files that the text names are
/// looked for in `folder`.
Scenario parse_scenario(const std::string& source, std::string text,
                        const std::filesystem::path& folder = {});
/// Throws FileError naming the line of what is wrong.
Scenario read_scenario(const std::filesystem::path& path);

/// One of those that come with the library. Throws FileError when there is none of that name.
Scenario shipped_scenario(const std::string& name);
std::vector<std::string> shipped_scenario_names();

}  // namespace evermap
