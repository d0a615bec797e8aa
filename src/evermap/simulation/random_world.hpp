// SPDX-FileCopyrightText: 2026 the evermap authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <array>
#include <cstdint>
#include <string>
#include <string_view>

#include <evermap/simulation/scenario_text.hpp>

namespace evermap {

/// Kinds of places that a robot may have to find its way in.
inline constexpr std::array<std::string_view, 11> kWorldKinds = {
    "room",   "corridor", "tunnel", "hall",    "warehouse", "containers",
    "street", "forest",   "quarry", "parking", "floors"};

/// A world of this kind as the text of a scenario (docs/scenarios.md), with a drive of some seconds in the
/// middle of it. The same seed gives the same text. REQUIRES: kind is one of kWorldKinds.
std::string random_world(std::string_view kind, std::uint64_t seed, const RandomDrive& drive);

}  // namespace evermap
