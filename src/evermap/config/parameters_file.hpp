// SPDX-FileCopyrightText: 2026 the evermap authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include <Eigen/Geometry>

#include <evermap/maintenance/parameters.hpp>

namespace evermap {

/// Sets the parameters that a YAML file names; the others stay as they are. Throws FileError with the line
/// of an unknown key, of one given twice, or of a value that is not in its range.
void read_parameters(const std::filesystem::path& path, Parameters& parameters);

/// The box that two opposite corners tell: x, y, z of one, then of the other. REQUIRES: six numbers.
Eigen::AlignedBox3d box_between(const std::vector<double>& corners);

/// All parameters as a YAML file that read_parameters takes: one a line, each with its unit, range, default
/// and meaning.
std::string to_yaml(const Parameters& parameters);

}  // namespace evermap
