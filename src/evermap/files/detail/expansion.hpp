// SPDX-FileCopyrightText: 2026 the evermap authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <algorithm>
#include <cstdint>

namespace evermap {

/// [bytes] How much memory compressed data may ask for: all that small files need, and for large ones far
/// more than the clouds of sensors, which seldom shrink to a fifth.
inline std::uint64_t greatest_expansion(std::uint64_t compressed_size) {
  constexpr std::uint64_t kAlways = std::uint64_t{256} << 20;
  constexpr std::uint64_t kMostExpansion = 64;
  return std::max(kAlways, kMostExpansion * compressed_size);
}

}  // namespace evermap
