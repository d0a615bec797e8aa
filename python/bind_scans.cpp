// SPDX-FileCopyrightText: 2026 the evermap authors
// SPDX-License-Identifier: BSD-3-Clause
#include <filesystem>
#include <limits>
#include <memory>
#include <pybind11/stl.h>
#include <pybind11/stl/filesystem.h>
#include <string>

#include <fmt/format.h>

#include "arrays.hpp"
#include "bindings.hpp"
#include <evermap/bags/scan_bag.hpp>
#include <evermap/io/cloud.hpp>
#include <evermap/io/poses.hpp>

namespace evermap {
namespace {

using namespace py::literals;

Scan make_scan(const py::object& points, const py::object& point_times, std::optional<double> time) {
  const std::vector<Eigen::Vector3d> all = points_of(points, "points");
  std::vector<float> times;
  if (!point_times.is_none()) times = floats_of(point_times, all.size(), "point_times");
  Scan scan = usable_scan(all, times);
  scan.time = time;
  return scan;
}

/// Scans of a recording, with their poses if these are asked for.
class Scans {
 public:
  Scans(const std::filesystem::path& path, const ScanOptions& options)
      : has_poses_(!options.reference.empty()), source_(open_scans(path, options)) {}

  Scan next() {
    std::optional<Scan> scan;
    {
      const py::gil_scoped_release without_interpreter;
      scan = source_->next();
      if (scan && has_poses_ && scan->time) scan->T_map_sensor = source_->pose_at(*scan->time);
    }
    if (!scan) throw py::stop_iteration();
    return std::move(*scan);
  }
  std::size_t size() const { return source_->size(); }
  std::vector<std::string> remarks() const { return source_->remarks(); }

 private:
  bool has_poses_;
  std::unique_ptr<ScanSource> source_;
};

Scans open(const std::filesystem::path& path, const std::string& topic, const std::string& format,
           double start, double duration, std::size_t every, const std::string& poses) {
  ScanOptions options;
  options.topic = topic;
  options.cloud.format = format;
  options.selection.start = start;
  options.selection.duration = duration;
  options.selection.every = every;
  options.reference = poses;
  if (every == 0) throw py::value_error("every is 0, not 1 or more");
  return {path, options};
}

py::tuple poses_of(const std::filesystem::path& path) {
  const std::vector<StampedPose> poses = read_poses(path).poses;
  const auto count = static_cast<py::ssize_t>(poses.size());
  py::array_t<double> matrices({count, py::ssize_t{4}, py::ssize_t{4}});
  std::vector<double> times;
  for (std::size_t i = 0; i < poses.size(); ++i) {
    write_matrix(poses[i].T_map_sensor, matrices.mutable_data() + 16 * i);
    if (poses[i].time) times.push_back(*poses[i].time);
  }
  const py::object stamps =
      times.empty() ? py::object(py::none()) : py::object(array_of_numbers(std::move(times)));
  return py::make_tuple(stamps, matrices);
}

void save_poses(const std::filesystem::path& path, const std::vector<double>& times,
                const py::sequence& poses) {
  if (times.size() != poses.size()) {
    throw py::value_error(fmt::format("{} times for {} poses", times.size(), poses.size()));
  }
  std::vector<StampedPose> stamped;
  for (std::size_t i = 0; i < times.size(); ++i) stamped.push_back({times[i], pose_of(poses[i], "poses")});
  write_tum_poses(path, stamped);
}

}  // namespace

void bind_scans(py::module_& module) {
  py::class_<Scan>(
      module, "Scan",
      "Returns of one revolution of a LiDAR. Wherever a Scan is taken, an array of points is, too.")
      .def(py::init(&make_scan), "points"_a, "point_times"_a = py::none(), "time"_a = py::none(),
           "points (N, 3) [m] in the sensor's frame; point_times (N,) [s] since the scan began; time [s] "
           "when it ended. Points that are not finite, or at the origin, are left out and counted.")
      .def_property_readonly(
          "points", [](const py::object& self) { return view_of(self.cast<const Scan&>().p_sensor, self); },
          "(N, 3) [m], a view, read only.")
      .def_property_readonly(
          "point_times",
          [](const Scan& scan) -> py::object {
            if (scan.time_offset.empty()) return py::none();
            return array_of_numbers(std::vector<float>(scan.time_offset));
          },
          "(N,) [s] since the scan began, or None.")
      .def_readwrite("time", &Scan::time, "[s] when the scan ended, or None.")
      .def_property_readonly(
          "pose",
          [](const Scan& scan) -> py::object {
            if (!scan.T_map_sensor) return py::none();
            return matrix_of(*scan.T_map_sensor);
          },
          "(4, 4) of the sensor when the scan ended, if the recording told it, or None.")
      .def_readonly("dropped_not_finite", &Scan::dropped_not_finite)
      .def_readonly("dropped_at_origin", &Scan::dropped_at_origin)
      .def("__len__", [](const Scan& scan) { return scan.p_sensor.size(); })
      .def("__repr__",
           [](const Scan& scan) { return fmt::format("<evermap.Scan of {} points>", scan.p_sensor.size()); });

  py::class_<Scans>(module, "Scans", "An iterator over the scans of a recording.")
      .def("__iter__", [](Scans& scans) -> Scans& { return scans; })
      .def("__next__", &Scans::next)
      .def("__len__", &Scans::size, "How many there are, as far as the recording says.")
      .def_property_readonly("remarks", &Scans::remarks,
                             "What is to be known of what was read, a sentence each.");

  module.def(
      "open_scans", &open, "path"_a, py::kw_only(), "topic"_a = "", "format"_a = "", "start"_a = 0.0,
      "duration"_a = std::numeric_limits<double>::infinity(), "every"_a = 1, "poses"_a = "",
      "Opens a bag (.bag, .db3, .mcap, or their folder), a folder of clouds, or one cloud. topic: of a bag "
      "with several; format: \".pcd\", whatever the names; start, duration [s]; every n-th scan; poses: a "
      "topic or frame of the bag that tells Scan.pose. Raises FileError.");
  module.def(
      "read_cloud", [](const std::filesystem::path& path) { return read_cloud(path); }, "path"_a,
      py::call_guard<py::gil_scoped_release>(), "Reads one cloud as a Scan. Raises FileError.");
  module.def(
      "read_poses", &poses_of, "path"_a,
      "(times, poses) of a TUM or KITTI file: (N,) [s], None for KITTI's, and (N, 4, 4). Raises FileError.");
  module.def("write_poses", &save_poses, "path"_a, "times"_a, "poses"_a,
             "Writes a TUM file atomically: times (N,) [s], poses (N, 4, 4). Raises FileError.");
}

}  // namespace evermap
