// SPDX-FileCopyrightText: 2026 the evermap authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <evermap/bags/detail/bag_reader.hpp>
#include <evermap/files/detail/input_file.hpp>

namespace evermap {

/// What bags have in common that are one file of records, some of which are chunks: records, compressed
/// together.
class ChunkedBag : public BagReader {
 protected:
  explicit ChunkedBag(const std::filesystem::path& path) : BagReader(path), file_(path) {}

  [[noreturn]] void fail(const std::string& message) const;
  [[noreturn]] void fail_at_end() const;

  bool begins_with(std::string_view magic);
  /// Goes on there, out of any chunk.
  void go_to(std::uint64_t position);
  /// Makes a chunk the one in hand; what is wrong with it is damage behind it.
  void open_chunk(std::string_view compression, std::string_view compressed, std::uint64_t size);
  /// What follows in the chunk in hand.
  std::string_view rest_of_chunk() const { return std::string_view(chunk_).substr(chunk_position_); }

  InputStream file_;
  std::string chunk_;
  std::size_t chunk_position_ = 0;  ///< [bytes]
};

}  // namespace evermap
