// SPDX-FileCopyrightText: 2026 the evermap authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <filesystem>
#include <string>

#include <evermap/update/parameters.hpp>

namespace evermap {

/// Sets the fields that a YAML file names; the others stay as they are. Throws IoError naming the line for an
/// unknown or repeated key, a value of the wrong type, or a number that is negative or not finite.
void read_parameters(const std::filesystem::path& path, UpdateParameters& parameters);

/// All fields as a YAML file with their units and meaning: what read_parameters reads back to equal values.
std::string to_yaml(const UpdateParameters& parameters);

}  // namespace evermap
