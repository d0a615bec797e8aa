// SPDX-FileCopyrightText: 2026 the evermap authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <CLI/CLI.hpp>

namespace evermap {

/// --domain and --local, with the defaults that ROS's environment gives.
void add_domain_options(CLI::App& verb, unsigned& domain, bool& is_local);

}  // namespace evermap
