// SPDX-FileCopyrightText: 2026 the evermap authors
// SPDX-License-Identifier: BSD-3-Clause
#include <pybind11/stl.h>
#include <vector>

#include "arrays.hpp"
#include "bindings.hpp"
#include <evermap/evaluation/map_metrics.hpp>
#include <evermap/evaluation/trajectory_metrics.hpp>

namespace evermap {
namespace {

using namespace py::literals;

std::vector<Pose> poses_of_sequence(const py::sequence& sequence, const char* name) {
  std::vector<Pose> poses;
  for (const py::handle& pose : sequence) poses.push_back(pose_of(pose, name));
  return poses;
}

}  // namespace

void bind_evaluation(py::module_& module) {
  py::class_<SurfaceComparison>(module, "SurfaceComparison",
                                "How well points of a map stand for the true surface.")
      .def(py::init([](const py::object& truth, const py::object& map) {
             const Points of_truth = points_of(truth, "truth");
             const Points of_map = points_of(map, "map");
             SurfaceComparison comparison;
             run_on(0, [&] { comparison = compare_surfaces(of_truth, of_map); });
             return comparison;
           }),
           "truth"_a, "map"_a, "Points (N, 3) and (M, 3) [m].")
      .def("coverage", &SurfaceComparison::coverage, "tolerance"_a,
           "COV: fraction of the truth within tolerance [m] of the map.")
      .def("accuracy", &SurfaceComparison::accuracy, "tolerance"_a,
           "ACC: fraction of the map within tolerance [m] of the truth.")
      .def_property_readonly("average_hausdorff_distance", &SurfaceComparison::average_hausdorff_distance,
                             "AHD [m]: the larger of the two mean distances.");
  py::class_<TrajectoryError>(module, "TrajectoryError",
                              "How far a trajectory is from the true one, pose by pose.")
      .def(py::init([](const py::sequence& truth, const py::sequence& found) {
             const std::vector<Pose> of_truth = poses_of_sequence(truth, "truth");
             const std::vector<Pose> of_found = poses_of_sequence(found, "found");
             if (of_truth.size() != of_found.size()) {
               throw py::value_error(std::to_string(of_found.size()) + " poses found for " +
                                     std::to_string(of_truth.size()) + " true ones");
             }
             return compare_trajectories(of_truth, of_found);
           }),
           "truth"_a, "found"_a, "Poses (N, 4, 4) each, paired by index.")
      .def_property_readonly("rmse", &TrajectoryError::translation_rmse, "[m] ATE, without alignment.")
      .def_property_readonly("max", &TrajectoryError::translation_max, "[m]")
      .def_property_readonly("rotation_rmse", &TrajectoryError::rotation_rmse, "[rad]")
      .def_property_readonly("fraction_lost", &TrajectoryError::fraction_lost,
                             "Off by more than 1 m or 5 degrees.");
}

}  // namespace evermap
