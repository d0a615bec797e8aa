// SPDX-FileCopyrightText: 2026 the evermap authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <pybind11/pybind11.h>

namespace evermap {

// Each adds its classes and functions to the module.
void bind_map(pybind11::module_& module);
void bind_scans(pybind11::module_& module);
void bind_maintenance(pybind11::module_& module);
void bind_simulation(pybind11::module_& module);
void bind_evaluation(pybind11::module_& module);

}  // namespace evermap
