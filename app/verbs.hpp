// SPDX-FileCopyrightText: 2026 the evermap authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <CLI/CLI.hpp>

namespace evermap {

/// Each adds one verb to the command line. The verb runs inside CLI::App::parse, as its callback, and reports
/// failure by an exception derived from std::exception.
void add_import(CLI::App& app);
void add_build(CLI::App& app);
void add_update(CLI::App& app);
void add_undo(CLI::App& app);
void add_log(CLI::App& app);
void add_diff(CLI::App& app);
void add_checkout(CLI::App& app);
void add_tag(CLI::App& app);
void add_prune(CLI::App& app);
void add_verify(CLI::App& app);
void add_repair(CLI::App& app);
void add_localize(CLI::App& app);
void add_export(CLI::App& app);
void add_info(CLI::App& app);
void add_config(CLI::App& app);
void add_evaluate(CLI::App& app);
void add_play(CLI::App& app);
void add_serve(CLI::App& app);
void add_simulate(CLI::App& app);
void add_view(CLI::App& app);

}  // namespace evermap
