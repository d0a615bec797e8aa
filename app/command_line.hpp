// SPDX-FileCopyrightText: 2026 the evermap authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <functional>
#include <string>

#include <CLI/CLI.hpp>

namespace evermap {

/// What every program of evermap does around its command line: sets up logging and memory, parses, and runs
/// the callbacks that `add_options` adds. Every error is one line on the standard error. Returns the exit
/// code: 0, 1 when the work failed, 2 when it was called wrongly.
int run_command_line(int argc, char** argv, const std::string& program, const std::string& description,
                     const std::function<void(CLI::App&)>& add_options);

}  // namespace evermap
