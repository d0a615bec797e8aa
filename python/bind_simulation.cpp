// SPDX-FileCopyrightText: 2026 the evermap authors
// SPDX-License-Identifier: BSD-3-Clause
#include <filesystem>
#include <memory>
#include <optional>
#include <pybind11/stl.h>
#include <string>

#include <fmt/format.h>

#include "arrays.hpp"
#include "bindings.hpp"
#include <evermap/evaluation/ray_coverage.hpp>
#include <evermap/simulation/change_truth.hpp>
#include <evermap/simulation/scenario_drive.hpp>

namespace evermap {
namespace {

using namespace py::literals;

/// A scenario, by the name of one that comes with evermap, or by a file.
std::unique_ptr<ScenarioDrive> simulate(const std::string& scenario, std::optional<int> scans,
                                        std::optional<std::uint64_t> seed) {
  const bool is_file = std::filesystem::path(scenario).has_extension();
  Scenario chosen = is_file ? read_scenario(scenario) : shipped_scenario(scenario);
  if (scans && *scans < 1) throw py::value_error("scans is less than 1");
  chosen.scans = scans.value_or(chosen.scans);
  chosen.seed = seed.value_or(chosen.seed);
  return std::make_unique<ScenarioDrive>(std::move(chosen));
}

std::size_t checked(const ScenarioDrive& drive, std::size_t index) {
  if (index >= drive.size()) throw py::index_error(fmt::format("scan {} of {}", index, drive.size()));
  return index;
}

/// (unchanged, removed): of the survey's surface, what the drive's rays could contradict.
py::tuple changes_of(const ScenarioDrive& drive, double resolution) {
  constexpr double kSpacing = 0.17;  // [m] no simple fraction of a leaf
  std::vector<Eigen::Vector3d> unchanged, removed;
  run_on(0, [&] {
    std::vector<ScanRays> rays(drive.size());
    for (std::size_t i = 0; i < drive.size(); ++i)
      rays[i] = {drive.T_map_sensor(i).translation, drive.in_map(i, drive.scan(i).scan)};
    const ChangeTruth truth =
        change_truth(drive.survey_scene(), drive.settled_scene(drive.size() - 1), kSpacing, resolution / 2);
    const VoxelGrid grid{.edge = resolution};
    unchanged = contradictable(truth.unchanged, grid, rays);
    removed = contradictable(truth.removed, grid, rays);
  });
  return py::make_tuple(array_of(std::move(unchanged)), array_of(std::move(removed)));
}

}  // namespace

void bind_simulation(py::module_& module) {
  py::class_<ScenarioDrive>(module, "Drive",
                            "A simulated drive through a world that changes: scans, poses, survey and truth.")
      .def("__len__", &ScenarioDrive::size)
      .def(
          "time", [](const ScenarioDrive& d, std::size_t i) { return d.time(checked(d, i)); }, "index"_a,
          "[s] of a scan's end.")
      .def(
          "pose",
          [](const ScenarioDrive& d, std::size_t i) { return matrix_of(d.T_map_sensor(checked(d, i))); },
          "index"_a, "(4, 4) of the sensor when a scan ended.")
      .def(
          "scan",
          [](const ScenarioDrive& d, std::size_t i) {
            Scan scan = d.scan(checked(d, i)).scan;
            scan.time = d.time(i);
            return scan;
          },
          "index"_a, py::call_guard<py::gil_scoped_release>(), "One revolution, as a Scan.")
      .def(
          "survey", [](const ScenarioDrive& d, double spacing) { return array_of(d.survey(spacing)); },
          "spacing"_a = 0.1, "(N, 3) [m]: the surface when the survey was made.")
      .def(
          "truth",
          [](const ScenarioDrive& d, std::size_t i, double spacing) {
            std::vector<Eigen::Vector3d> points;
            for (const SurfaceSample& sample : sample_surface(d.settled_scene(checked(d, i)), spacing))
              points.push_back(sample.p_map);
            return array_of(std::move(points));
          },
          "index"_a, "spacing"_a = 0.17, "(N, 3) [m]: the true surface at a scan, without what moves.")
      .def("changes", &changes_of, "resolution"_a,
           "(unchanged, removed), (N, 3) [m]: of the survey's surface, what still is there at the end and "
           "what is gone, where the drive's rays could tell in leaves of `resolution` [m].");
  module.def("simulate", &simulate, "scenario"_a, py::kw_only(), "scans"_a = py::none(),
             "seed"_a = py::none(),
             "A drive through quarry, yard, passing or street, or a scenario's file. scans: another number; "
             "seed: of the sensor's noise. Raises FileError.");
}

}  // namespace evermap
