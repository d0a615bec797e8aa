// SPDX-FileCopyrightText: 2026 the evermap authors
// SPDX-License-Identifier: BSD-3-Clause
#include <algorithm>

#include <evermap/io/detail/lzf.hpp>

namespace evermap {

// An instruction begins with a control byte:
//   000LLLLL                    L + 1 literal bytes follow
//   LLLooooo oooooooo           copy L + 2 bytes (L = 1..6) from o + 1 bytes back
//   111ooooo LLLLLLLL oooooooo  copy L + 9 bytes from o + 1 bytes back; source and target may overlap
std::optional<std::size_t> lzf_decompress(std::string_view compressed, std::span<char> output) {
  std::size_t in = 0;
  std::size_t out = 0;
  const auto byte = [&](std::size_t i) { return std::size_t{static_cast<unsigned char>(compressed[i])}; };
  while (in < compressed.size()) {
    const std::size_t start = in;
    const std::size_t control = byte(in++);
    if (control < 32) {
      const std::size_t length = control + 1;
      if (length > compressed.size() - in || length > output.size() - out) return start;
      std::copy_n(compressed.data() + in, length, output.data() + out);
      in += length;
      out += length;
      continue;
    }
    const bool is_long = control >> 5 == 7;
    if (compressed.size() - in < (is_long ? 2U : 1U)) return start;
    const std::size_t length = (is_long ? 7 + byte(in++) : control >> 5) + 2;
    const std::size_t distance = ((control & 31) << 8 | byte(in++)) + 1;
    if (distance > out || length > output.size() - out) return start;
    // Byte by byte: where the ranges overlap, the copy repeats what it has just written.
    for (std::size_t i = 0; i < length; ++i, ++out) output[out] = output[out - distance];
  }
  if (out != output.size()) return compressed.size();
  return std::nullopt;
}

}  // namespace evermap
