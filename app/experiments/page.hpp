// SPDX-FileCopyrightText: 2026 the evermap authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <vector>

#include "experiments/experiment.hpp"
#include "experiments/laboratory.hpp"

namespace evermap {

/// Writes index.html, which tells all, and experiments.md, its text and tables.
void write_page(const Laboratory& laboratory, const Setup& setup, const std::vector<Story>& stories);

/// The results of an experiment by the names of its units, for machines; what only pictures need is left out.
Json to_json(const Experiment& experiment, const std::vector<Json>& results);

}  // namespace evermap
