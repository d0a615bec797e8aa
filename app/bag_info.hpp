// SPDX-FileCopyrightText: 2026 the evermap authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <filesystem>

namespace evermap {

/// Prints what is in a bag, and the command that would use it. Throws FileError when it cannot be read.
void print_bag_info(const std::filesystem::path& bag, bool as_json);

}  // namespace evermap
