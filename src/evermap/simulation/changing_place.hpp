// SPDX-FileCopyrightText: 2026 the evermap authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <array>
#include <cstdint>
#include <string>
#include <string_view>

#include <evermap/simulation/scenario_text.hpp>

namespace evermap {

/// Places that a robot drives through day by day, and that change from one night to the next:
///
/// - container terminal: a level yard with stacks of containers in marked bays and four masts. Each night a
///   fraction `changed` of the bays is emptied, filled, or gets another container, never quite where the
///   one before stood.
/// - pit: a quarry. Each night the next two of the 18 blocks that are its walls are blasted back by 2.5 m and
///   the next of seven strips of its floor is dug 0.4 m deeper; piles (a fraction `changed`) and machines
///   (twice that) come and go.
inline constexpr std::array<std::string_view, 2> kChangingPlaces = {"container terminal", "pit"};

/// The place after so many nights, as the text of a scenario in which nothing else changes, with the robot's
/// daily round. The same seed gives the same year. REQUIRES: place is one of kChangingPlaces, nights >= 0.
std::string changing_place(std::string_view place, std::uint64_t seed, int nights, const RandomDrive& drive);

}  // namespace evermap
