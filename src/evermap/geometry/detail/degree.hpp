// SPDX-FileCopyrightText: 2026 the evermap authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <numbers>

namespace evermap {

inline constexpr double kDegree = std::numbers::pi / 180;  ///< [rad]

}  // namespace evermap
