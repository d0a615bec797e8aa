// SPDX-FileCopyrightText: 2026 the evermap authors
// SPDX-License-Identifier: BSD-3-Clause
#include <algorithm>

#include <evermap/bags/detail/chunked_bag.hpp>
#include <evermap/bags/detail/decompress.hpp>

namespace evermap {

void ChunkedBag::fail(const std::string& message) const {
  throw FileError::at_byte(path(), file_.position(), message);
}

void ChunkedBag::fail_at_end() const {
  fail("ends inside a record; the recording was cut off, or copy the file again");
}

bool ChunkedBag::begins_with(std::string_view magic) {
  std::string bytes;
  file_.append_to(bytes, std::min<std::uint64_t>(magic.size(), file_.rest()));
  return bytes == magic;
}

void ChunkedBag::go_to(std::uint64_t position) {
  file_.seek(position);
  chunk_.clear();
  chunk_position_ = 0;
}

void ChunkedBag::open_chunk(std::string_view compression, std::string_view compressed, std::uint64_t size) {
  chunk_position_ = 0;
  const std::optional<std::string> fault = decompress(compression, compressed, size, chunk_);
  if (!fault) return;
  chunk_.clear();
  fail("the chunk before " + *fault + "; copy the file again");
}

}  // namespace evermap
