// SPDX-FileCopyrightText: 2026 the evermap authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cmath>
#include <cstdint>
#include <numbers>

#include <evermap/geometry/voxel_key.hpp>

namespace evermap {

/// Uniform in (0, 1], number `index` of the sequence that `seed` names. Unlike the standard library's
/// generators it gives the same in any order of calls.
inline double uniform(std::uint64_t seed, std::uint64_t index) {
  constexpr std::uint64_t kGoldenRatio = 0x9e3779b97f4a7c15U;  // of SplitMix64
  const std::uint64_t bits = hash_bits(hash_bits(seed + kGoldenRatio) + index * kGoldenRatio);
  return static_cast<double>((bits >> 11) + 1) * 0x1p-53;
}

/// Standard normal (Box and Muller, 1958), number `index` of the sequence that `seed` names. Unlike
/// std::normal_distribution it is the same with every standard library and in any order of calls.
inline double standard_normal(std::uint64_t seed, std::uint64_t index) {
  const double radius = std::sqrt(-2 * std::log(uniform(seed, 2 * index)));
  return radius * std::cos(2 * std::numbers::pi * uniform(seed, 2 * index + 1));
}

}  // namespace evermap
