// SPDX-FileCopyrightText: 2026 the evermap authors
// SPDX-License-Identifier: BSD-3-Clause
#include "arrays.hpp"

#include <utility>

#include <oneapi/tbb/task_arena.h>

namespace evermap {
namespace {

std::string shape_of(const py::array& array) {
  std::string shape = "(";
  for (py::ssize_t i = 0; i < array.ndim(); ++i)
    shape += (i > 0 ? ", " : "") + std::to_string(array.shape(i));
  return shape + (array.ndim() == 1 ? ",)" : ")");
}

py::array_t<double> doubles_of(const py::handle& value, const char* name) {
  const py::array array = py::array::ensure(value);
  if (!array) {
    PyErr_Clear();
    throw py::type_error(std::string(name) + " is no array of numbers");
  }
  const char kind = array.dtype().kind();
  if (kind != 'f' && kind != 'i' && kind != 'u') {
    throw py::type_error(std::string(name) + " holds " + std::string(py::str(array.dtype())) +
                         ", not real numbers");
  }
  return py::array_t<double, py::array::c_style | py::array::forcecast>::ensure(array);
}

[[noreturn]] void fail(const char* name, const py::array& array, const char* expected) {
  throw py::value_error(std::string(name) + " has the shape " + shape_of(array) + ", not " + expected);
}

constexpr double kRotationTolerance = 1e-3;

}  // namespace

std::vector<Eigen::Vector3d> points_of(const py::handle& value, const char* name) {
  const py::array_t<double> array = doubles_of(value, name);
  if (array.ndim() != 2 || array.shape(1) != 3) fail(name, array, "(N, 3)");
  const auto* first = reinterpret_cast<const Eigen::Vector3d*>(array.data());
  return {first, first + array.shape(0)};
}

Pose pose_of(const py::handle& value, const char* name) {
  const py::array_t<double> array = doubles_of(value, name);
  if (array.ndim() != 2 || array.shape(0) != 4 || array.shape(1) != 4) fail(name, array, "(4, 4)");
  const Eigen::Map<const Eigen::Matrix<double, 4, 4, Eigen::RowMajor>> matrix(array.data());
  const Eigen::Matrix3d rotation = matrix.topLeftCorner<3, 3>();
  const bool is_affine = matrix.row(3) == Eigen::RowVector4d(0, 0, 0, 1);
  if (!matrix.allFinite() || !is_affine || !is_rotation(rotation, kRotationTolerance))
    throw py::value_error(std::string(name) + " is no rigid motion [R t; 0 0 0 1]");
  return {nearest_rotation(rotation), matrix.topRightCorner<3, 1>()};
}

std::optional<Pose> optional_pose_of(const py::object& value, const char* name) {
  return value.is_none() ? std::nullopt : std::optional(pose_of(value, name));
}

std::optional<Eigen::Matrix3d> optional_rotation_of(const py::object& value, const char* name) {
  if (value.is_none()) return std::nullopt;
  const py::array_t<double> array = doubles_of(value, name);
  if (array.ndim() != 2 || array.shape(0) != 3 || array.shape(1) != 3) fail(name, array, "(3, 3)");
  const Eigen::Matrix3d rotation =
      Eigen::Map<const Eigen::Matrix<double, 3, 3, Eigen::RowMajor>>(array.data());
  if (!rotation.allFinite() || !is_rotation(rotation, kRotationTolerance))
    throw py::value_error(std::string(name) + " is no rotation");
  return nearest_rotation(rotation);
}

std::vector<float> floats_of(const py::handle& value, std::size_t count, const char* name) {
  const py::array_t<double> array = doubles_of(value, name);
  if (array.ndim() != 1 || static_cast<std::size_t>(array.shape(0)) != count)
    fail(name, array, ("(" + std::to_string(count) + ",), one for each point").c_str());
  return {array.data(), array.data() + array.shape(0)};
}

Scan usable_scan(const std::vector<Eigen::Vector3d>& points, const std::vector<float>& times) {
  Scan scan;
  for (std::size_t i = 0; i < points.size(); ++i) {
    if (!points[i].allFinite()) {
      ++scan.dropped_not_finite;
    } else if (points[i] == Eigen::Vector3d::Zero()) {
      ++scan.dropped_at_origin;
    } else {
      scan.p_sensor.push_back(points[i]);
      if (!times.empty()) scan.time_offset.push_back(times[i]);
    }
  }
  return scan;
}

const Scan& scan_of(const py::handle& value, Scan& made) {
  if (py::isinstance<Scan>(value)) return value.cast<const Scan&>();
  made = usable_scan(points_of(value, "scan"));
  return made;
}

py::array array_of(std::vector<Eigen::Vector3d> points) {
  auto* kept = new std::vector<Eigen::Vector3d>(std::move(points));
  const py::capsule owner(kept, [](void* data) { delete static_cast<std::vector<Eigen::Vector3d>*>(data); });
  return py::array_t<double>({static_cast<py::ssize_t>(kept->size()), py::ssize_t{3}},
                             reinterpret_cast<const double*>(kept->data()), owner);
}

py::array view_of(const std::vector<Eigen::Vector3d>& points, py::handle owner) {
  py::array_t<double> view({static_cast<py::ssize_t>(points.size()), py::ssize_t{3}},
                           reinterpret_cast<const double*>(points.data()), owner);
  view.attr("setflags")(py::arg("write") = false);
  return view;
}

void write_matrix(const Pose& pose, double* numbers) {
  Eigen::Map<Eigen::Matrix<double, 4, 4, Eigen::RowMajor>> matrix(numbers);
  matrix.setIdentity();
  matrix.topLeftCorner<3, 3>() = pose.rotation;
  matrix.topRightCorner<3, 1>() = pose.translation;
}

py::array matrix_of(const Pose& pose) {
  py::array_t<double> matrix({4, 4});
  write_matrix(pose, matrix.mutable_data());
  return matrix;
}

py::array matrix_of(const Eigen::Matrix<double, 6, 6>& matrix) {
  py::array_t<double> result({6, 6});
  Eigen::Map<Eigen::Matrix<double, 6, 6, Eigen::RowMajor>>(result.mutable_data()) = matrix;
  return result;
}

void run_on(int threads, const std::function<void()>& work) {
  const py::gil_scoped_release without_interpreter;
  oneapi::tbb::task_arena arena(threads > 0 ? threads : oneapi::tbb::task_arena::automatic);
  arena.execute(work);
}

}  // namespace evermap
