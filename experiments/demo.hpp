// SPDX-FileCopyrightText: 2026 the evermap authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <filesystem>

#include "report.hpp"

namespace evermap {

/// Simulates a yard that changed and lets all mappers maintain its map. Writes evermap's map before and after
/// and pictures of both into the folder. Returns the results as of an experiment "demo". Throws FileError
/// when a file cannot be written.
Json run_demo(const std::filesystem::path& folder);

}  // namespace evermap
