// SPDX-FileCopyrightText: 2026 the evermap authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstddef>
#include <optional>
#include <span>
#include <string_view>

namespace evermap {

/// No three bytes of an LZF stream stand for more than 264 bytes: what a claimed size can be checked against.
inline constexpr std::size_t kLzfMaxRatio = 88;

/// Fills `output` from `compressed` in the LZF format (Marc Lehmann's liblzf, as in binary_compressed PCD).
/// Returns none when exactly all of `output` was filled by all of `compressed`, otherwise the offset [bytes]
/// in `compressed` of the instruction that is damaged.
std::optional<std::size_t> lzf_decompress(std::string_view compressed, std::span<char> output);

}  // namespace evermap
