// SPDX-FileCopyrightText: 2026 the evermap authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "experiments/experiment.hpp"

namespace evermap {

/// The units of an experiment by name: title, settings and result. REQUIRES: results are in their order.
Json to_json(const Experiment& experiment, const std::vector<Json>& results);

/// The same without the maps' views from above, which only pictures need.
Json without_views(Json units);

/// One line for each figure, for spreadsheets: unit, mapper, scan (none at the end), metric, value.
std::string to_csv(const Json& units);

/// Atomically. Throws FileError when it cannot be written.
void write_file(const std::filesystem::path& file, const std::string& text);

}  // namespace evermap
