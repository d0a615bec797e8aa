// SPDX-FileCopyrightText: 2026 the evermap authors
// SPDX-License-Identifier: BSD-3-Clause
#include "bindings.hpp"
#include <evermap/files/file_error.hpp>

PYBIND11_MODULE(_evermap, module) {
  module.attr("__version__") = EVERMAP_VERSION;
  pybind11::register_exception<evermap::FileError>(module, "FileError", PyExc_RuntimeError).doc() =
      "A file cannot be read or written, or holds what cannot be right: one line, with path and place.";
  evermap::bind_map(module);
  evermap::bind_scans(module);
  evermap::bind_maintenance(module);
  evermap::bind_simulation(module);
  evermap::bind_evaluation(module);
}
