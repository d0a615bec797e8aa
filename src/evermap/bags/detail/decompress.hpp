// SPDX-FileCopyrightText: 2026 the evermap authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <filesystem>
#include <optional>
#include <string>
#include <string_view>

namespace evermap {

/// Replaces `output` by the `size` bytes that `compressed` holds. Compressions have the names they have in
/// bags: "none" or "", "bz2", "lz4", "zstd". Returns what is wrong where that fails, in a few words, and
/// nothing otherwise. Takes memory as the data come, and for no more than greatest_expansion() allows.
std::optional<std::string> decompress(std::string_view compression, std::string_view compressed,
                                      std::uint64_t size, std::string& output);

/// Whether bytes begin as a frame of Zstandard, and what the first frame says it holds [bytes].
bool is_zstd(std::string_view bytes);
std::optional<std::uint64_t> zstd_size(std::string_view bytes);

/// A copy of a file without its Zstandard compression, which is removed in the end. Throws FileError.
class UncompressedCopy {
 public:
  explicit UncompressedCopy(const std::filesystem::path& compressed);
  ~UncompressedCopy();
  UncompressedCopy(const UncompressedCopy&) = delete;
  UncompressedCopy& operator=(const UncompressedCopy&) = delete;

  const std::filesystem::path& path() const { return path_; }

 private:
  std::filesystem::path path_;
};

}  // namespace evermap
