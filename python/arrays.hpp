// SPDX-FileCopyrightText: 2026 the evermap authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <functional>
#include <memory>
#include <optional>
#include <pybind11/numpy.h>
#include <pybind11/pybind11.h>
#include <string>
#include <vector>

#include <Eigen/Core>

#include <evermap/geometry/pose.hpp>
#include <evermap/scan/scan.hpp>

namespace evermap {

namespace py = pybind11;

// NumPy in and out. What comes in is checked: TypeError for what holds no real numbers, ValueError for
// another shape or for values that make no sense, both naming the argument.

/// N x 3 numbers of any real type and layout.
std::vector<Eigen::Vector3d> points_of(const py::handle& value, const char* name);
/// A rigid motion as a 4 x 4 matrix.
Pose pose_of(const py::handle& value, const char* name);
std::optional<Pose> optional_pose_of(const py::object& value, const char* name);
/// A rotation as a 3 x 3 matrix.
std::optional<Eigen::Matrix3d> optional_rotation_of(const py::object& value, const char* name);
/// A Scan, or an array of points, of which one is made in `made`.
const Scan& scan_of(const py::handle& value, Scan& made);
/// The points that can be used, with their times if there are any; the others are counted.
Scan usable_scan(const std::vector<Eigen::Vector3d>& points, const std::vector<float>& times = {});
/// N numbers.
std::vector<float> floats_of(const py::handle& value, std::size_t count, const char* name);

/// An N x 3 array that owns these points; nothing is copied.
py::array array_of(std::vector<Eigen::Vector3d> points);
/// A view of points that `owner` keeps, read only.
py::array view_of(const std::vector<Eigen::Vector3d>& points, py::handle owner);
/// Writes a pose as a 4 x 4 matrix to these 16 numbers.
void write_matrix(const Pose& pose, double* numbers);
py::array matrix_of(const Pose& pose);
py::array matrix_of(const Eigen::Matrix<double, 6, 6>& matrix);

/// An array that owns a vector of numbers.
template <class Number>
py::array array_of_numbers(std::vector<Number> values) {
  auto* kept = new std::vector<Number>(std::move(values));
  const py::capsule owner(kept, [](void* data) { delete static_cast<std::vector<Number>*>(data); });
  return py::array_t<Number>(static_cast<py::ssize_t>(kept->size()), kept->data(), owner);
}

/// Work that needs no interpreter, on so many threads (0: one per core).
void run_on(int threads, const std::function<void()>& work);

}  // namespace evermap
