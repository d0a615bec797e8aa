// SPDX-FileCopyrightText: 2026 the evermap authors
// SPDX-License-Identifier: BSD-3-Clause
#include <filesystem>
#include <pybind11/stl/filesystem.h>
#include <string>
#include <utility>
#include <vector>

#include <fmt/format.h>

#include "arrays.hpp"
#include "bindings.hpp"
#include <evermap/evaluation/map_claims.hpp>
#include <evermap/history/map_history.hpp>
#include <evermap/io/map_file.hpp>
#include <evermap/maintenance/survey.hpp>
#include <evermap/map/map_difference.hpp>

namespace evermap {
namespace {

using namespace py::literals;

Octree empty_map_around(const Eigen::Vector3d& center, double resolution) {
  if (!is_leaf_edge(resolution)) {
    throw py::value_error(
        fmt::format("resolution is {} m, not {} to {} m", resolution, kLeastLeafEdge, kGreatestLeafEdge));
  }
  return Octree(VoxelGrid::around(center, resolution));
}

Octree empty_map(double resolution, const py::object& center) {
  if (center.is_none()) return empty_map_around(Eigen::Vector3d::Zero(), resolution);
  const std::vector<Eigen::Vector3d> centers = points_of(py::list(py::make_tuple(center)), "center");
  if (!centers.front().allFinite()) throw py::value_error("center is not finite");
  return empty_map_around(centers.front(), resolution);
}

Octree map_of_cloud(const py::object& points, double resolution) {
  Scan cloud;
  cloud.p_sensor = points_of(points, "points");
  std::erase_if(cloud.p_sensor, [](const Eigen::Vector3d& p) { return !p.allFinite(); });
  if (cloud.p_sensor.empty()) throw py::value_error("points holds none that is finite");
  Octree map = empty_map_around(cloud.p_sensor[cloud.p_sensor.size() / 2], resolution);
  run_on(0, [&] { add_survey(map, cloud, Pose{}); });
  return map;
}

/// (means, covariances, counts, log_odds) of the leaves, in the order of their keys.
py::tuple leaves_of(const Octree& map, bool occupied_only) {
  std::vector<Eigen::Vector3d> means;
  std::vector<double> covariances;
  std::vector<double> counts;
  std::vector<double> log_odds;
  map.for_each_leaf([&](VoxelKey key, const Leaf& leaf) {
    if (occupied_only && !leaf.occupied()) return;
    const Gaussian surface = map.gaussian(key, leaf);
    means.push_back(surface.mean);
    covariances.insert(covariances.end(), surface.covariance.data(), surface.covariance.data() + 9);
    counts.push_back(surface.count);
    log_odds.push_back(static_cast<double>(leaf.log_odds));
  });
  const auto count = static_cast<py::ssize_t>(means.size());
  return py::make_tuple(
      array_of(std::move(means)),
      array_of_numbers(std::move(covariances)).reshape({count, py::ssize_t{3}, py::ssize_t{3}}),
      array_of_numbers(std::move(counts)), array_of_numbers(std::move(log_odds)));
}

py::array points_of_leaves(const Octree& map, const std::vector<VoxelKey>& keys) {
  std::vector<Eigen::Vector3d> points;
  points.reserve(keys.size());
  for (const VoxelKey key : keys) points.push_back(map.gaussian(key, *map.find(key)).mean);
  return array_of(std::move(points));
}

py::tuple compare_maps(const Octree& before, const Octree& after) {
  if (before.grid() != after.grid()) throw py::value_error("the maps have different grids");
  MapDifference difference;
  run_on(0, [&] { difference = compare(before, after); });
  return py::make_tuple(points_of_leaves(after, difference.added),
                        points_of_leaves(before, difference.removed),
                        points_of_leaves(after, difference.moved));
}

std::vector<bool> claimed(const Octree& map, const py::object& points, double position_sigma) {
  const std::vector<Eigen::Vector3d> asked = points_of(points, "points");
  std::vector<bool> answers;
  answers.reserve(asked.size());
  for (const Eigen::Vector3d& p : asked) answers.push_back(claims(map, p, position_sigma));
  return answers;
}

}  // namespace

void bind_map(py::module_& module) {
  py::class_<Octree>(
      module, "Map",
      "Surface in a sparse voxel octree: leaves with a Gaussian and an occupancy. Several threads "
      "may read a map at once. MapMaintainer changes maps; this one never changes.")
      .def(py::init(&empty_map), "resolution"_a, "center"_a = py::none(),
           "An empty map with leaves of `resolution` [m]. `center` (3,) [m]: about where it will be.")
      .def_static("load", &load_map_version, "path"_a, py::call_guard<py::gil_scoped_release>(),
                  "Reads map.evm, or a version of it, map.evm@3. Raises FileError.")
      .def_static("from_cloud", &map_of_cloud, "points"_a, "resolution"_a,
                  "A map of a survey, points (N, 3) [m] in the map's frame, all of which is trusted.")
      .def(
          "save", [](const Octree& map, const std::filesystem::path& path) { save_map(path, map); }, "path"_a,
          py::call_guard<py::gil_scoped_release>(),
          "Writes the map atomically; without a history, which is for `evermap` and MapStore. Raises "
          "FileError.")
      .def_property_readonly(
          "resolution", [](const Octree& map) { return map.grid().edge; }, "Edge of a leaf [m].")
      .def("__len__", &Octree::leaf_count, "Leaves, pending ones included.")
      .def(
          "surface", [](const Octree& map) { return array_of(surface_points(map)); },
          "(N, 3) [m]: the mean of every occupied leaf.")
      .def("_leaves", &leaves_of, "occupied_only"_a)
      .def(
          "claims",
          [](const Octree& map, const py::object& points, double position_sigma) {
            const std::vector<bool> answers = claimed(map, points, position_sigma);
            py::array_t<bool> result(static_cast<py::ssize_t>(answers.size()));
            std::copy(answers.begin(), answers.end(), result.mutable_data());
            return result;
          },
          "points"_a, "position_sigma"_a = 0.02,
          "(N,) bool: whether the map shows surface at points (N, 3) [m], known to `position_sigma` [m].")
      .def("__repr__", [](const Octree& map) {
        return fmt::format("<evermap.Map of {} leaves of {} m>", map.leaf_count(), map.grid().edge);
      });
  module.def("_compare", &compare_maps, "before"_a, "after"_a);
}

}  // namespace evermap
