// SPDX-FileCopyrightText: 2026 the evermap authors
// SPDX-License-Identifier: BSD-3-Clause
#include <filesystem>
#include <pybind11/stl.h>
#include <pybind11/stl/filesystem.h>
#include <string>

#include <fmt/format.h>

#include "arrays.hpp"
#include "bindings.hpp"
#include <evermap/config/parameters_file.hpp>
#include <evermap/maintenance/map_maintainer.hpp>

namespace evermap {
namespace {

using namespace py::literals;

MapMode mode_named(const std::string& name) {
  if (name == "maintenance") return MapMode::kMaintenance;
  if (name == "mapping") return MapMode::kMapping;
  if (name == "localization") return MapMode::kLocalization;
  throw py::value_error("mode is \"" + name + "\", not maintenance, mapping or localization");
}

/// A MapMaintainer with its threads.
class Maintainer {
 public:
  Maintainer(const Octree& map, const Parameters& parameters, const std::string& mode,
             const py::object& initial_pose, int threads)
      : maintainer_(map, parameters, mode_named(mode),
                    optional_pose_of(initial_pose, "initial_pose").value_or(Pose{})),
        threads_(threads) {}

  ScanResult process(const py::object& scan, double time, const py::object& odometry,
                     const py::object& orientation) {
    Scan made;
    const Scan& given = scan_of(scan, made);
    const std::optional<Pose> T_odom_sensor = optional_pose_of(odometry, "odometry");
    const std::optional<Eigen::Matrix3d> R_inertial_sensor = optional_rotation_of(orientation, "orientation");
    ScanResult result;
    run_on(threads_, [&] { result = maintainer_.process(given, time, T_odom_sensor, R_inertial_sensor); });
    return result;
  }

  ScanResult update(const py::object& scan, const py::object& pose, const py::object& begin_pose) {
    Scan made;
    const Scan& given = scan_of(scan, made);
    const Pose T_map_sensor = pose_of(pose, "pose");
    const std::optional<Pose> T_map_sensor_begin = optional_pose_of(begin_pose, "begin_pose");
    ScanResult result;
    run_on(threads_, [&] { result = maintainer_.process(given, T_map_sensor, T_map_sensor_begin); });
    return result;
  }

  Octree map() const { return maintainer_.map(); }
  std::string state() const { return std::string(to_string(maintainer_.state())); }

 private:
  MapMaintainer maintainer_;
  int threads_;
};

}  // namespace

void bind_maintenance(py::module_& module) {
  py::class_<LidarParameters>(module, "LidarParameters", "The sensor.")
      .def_readwrite("min_range", &LidarParameters::min_range, "[m]")
      .def_readwrite("max_range", &LidarParameters::max_range, "[m]")
      .def_readwrite("range_sigma", &LidarParameters::range_sigma,
                     "[m] standard deviation of a return's distance")
      .def_readwrite("scan_period", &LidarParameters::scan_period,
                     "[s] from the first return of a scan to the last");
  py::class_<Parameters>(
      module, "Parameters",
      "All that governs evermap. str() is the YAML that read() takes, with a line on each.")
      .def(py::init<>())
      .def_static("paper", &Parameters::paper, "The rules of the published method.")
      .def_static(
          "read",
          [](const std::filesystem::path& path) {
            Parameters parameters;
            read_parameters(path, parameters);
            return parameters;
          },
          "path"_a, "The defaults, less what a YAML file says. Raises FileError with the line.")
      .def_readwrite("lidar", &Parameters::lidar)
      .def("__str__", &to_yaml);

  py::class_<ScanResult>(module, "ScanResult", "What a MapMaintainer made of a scan.")
      .def_readonly("time", &ScanResult::time, "[s] when it ended, of a scan that was located")
      .def_property_readonly(
          "pose", [](const ScanResult& r) { return matrix_of(r.T_map_sensor); },
          "(4, 4) T_map_sensor when the scan ended; nothing to rely on unless is_believed.")
      .def_property_readonly(
          "covariance", [](const ScanResult& r) { return matrix_of(r.covariance); },
          "(6, 6) [m, rad] of (translation, rotation about the sensor) in the map's axes.")
      .def_property_readonly("is_believed", &ScanResult::is_believed)
      .def_property_readonly(
          "state", [](const ScanResult& r) { return std::string(to_string(r.state)); },
          "starting, tracking, degraded or lost.")
      .def_property_readonly(
          "reject_reason", [](const ScanResult& r) { return std::string(to_string(r.reject_reason)); },
          "Why it is not believed or not written, in words; empty when it is.")
      .def_readonly("unobservable", &ScanResult::unobservable)
      .def_readonly("inlier_fraction", &ScanResult::inlier_fraction)
      .def_readonly("contradicting_fraction", &ScanResult::contradicting_fraction)
      .def_readonly("is_written", &ScanResult::is_written)
      .def_readonly("leaves_occupied", &ScanResult::leaves_occupied, "Leaves that became occupied.")
      .def_readonly("leaves_erased", &ScanResult::leaves_erased, "Occupied leaves that went.")
      .def_readonly("rolled_back", &ScanResult::rolled_back,
                    "Earlier scans whose changes were undone, since the robot is lost.")
      .def_readonly("confirmed", &ScanResult::confirmed,
                    "Results of earlier scans that are believed since this one: those of a start.")
      .def_property_readonly("points_used", [](const ScanResult& r) { return r.points.used; })
      .def("__repr__", [](const ScanResult& r) {
        return fmt::format("<evermap.ScanResult: {}{}{}>", to_string(r.state),
                           r.reject_reason == RejectReason::kNone ? "" : ", ", to_string(r.reject_reason));
      });

  py::class_<Maintainer>(
      module, "MapMaintainer",
      "The closed loop: localizes a LiDAR in a map and keeps the map true, scan by scan. The "
      "interpreter is free meanwhile: one thread may process while others ask for the map.")
      .def(
          py::init<const Octree&, const Parameters&, const std::string&, const py::object&, int>(), "map"_a,
          "parameters"_a = Parameters{}, py::kw_only(), "mode"_a = "maintenance",
          "initial_pose"_a = py::none(), "threads"_a = 0,
          "initial_pose (4, 4): where the first scan is, within about 1 m and 10 degrees. mode: maintenance, "
          "mapping (nothing is contradicted) or localization (nothing is written). threads: 0 is one per "
          "core.")
      .def("process", &Maintainer::process, "scan"_a, "time"_a, "odometry"_a = py::none(),
           "orientation"_a = py::none(),
           "Takes a scan whose pose is to be found. time [s]: when it ended. odometry (4, 4): the sensor's "
           "pose then in a frame that may drift; orientation (3, 3): its rotation alone, from a gyroscope; "
           "each "
           "given for each scan or for none.")
      .def("update", &Maintainer::update, "scan"_a, "pose"_a, "begin_pose"_a = py::none(),
           "Takes a scan whose pose (4, 4) is known and trusted. begin_pose: when the scan began; with it, a "
           "scan with point_times is deskewed.")
      .def_property_readonly("map", &Maintainer::map, "The map as it is now; a snapshot that costs little.")
      .def_property_readonly("state", &Maintainer::state);
}

}  // namespace evermap
