// SPDX-FileCopyrightText: 2026 the evermap authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <string_view>

namespace evermap {

/// The page that `viewer/` is built to: one file of HTML with all that it needs.
std::string_view page();

}  // namespace evermap
