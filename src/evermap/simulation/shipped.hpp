// SPDX-FileCopyrightText: 2026 the evermap authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <string_view>
#include <utility>
#include <vector>

namespace evermap {

/// The texts of the folder scenarios/ by name, put into the library when it is built.
const std::vector<std::pair<std::string_view, std::string_view>>& shipped_texts();

}  // namespace evermap
