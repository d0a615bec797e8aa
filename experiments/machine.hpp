// SPDX-FileCopyrightText: 2026 the evermap authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <string>

#include "report.hpp"

namespace evermap {

/// Names this very build of the program.
std::string program_fingerprint();

std::string processor();
std::string compiler();

/// What figures depend on besides the method: processor, compiler, versions of libraries.
Json machine_facts();

}  // namespace evermap
