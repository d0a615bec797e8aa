// SPDX-FileCopyrightText: 2026 the evermap authors
// SPDX-License-Identifier: BSD-3-Clause
#include <algorithm>
#include <cstdint>
#include <limits>
#include <optional>

#ifdef EVERMAP_READ_GZIP
#include <zlib.h>
#endif

#include <evermap/files/detail/expansion.hpp>
#include <evermap/files/detail/gzip.hpp>
#include <evermap/files/file_error.hpp>

namespace evermap {

bool is_gzip(const std::filesystem::path& path) {
  const std::string extension = path.extension().string();
  return extension == ".gz" || extension == ".GZ";
}

std::filesystem::path without_gzip(const std::filesystem::path& path) {
  return is_gzip(path) ? path.parent_path() / path.stem() : path;
}

#ifdef EVERMAP_READ_GZIP

namespace {

/// One member of gzip after the other, from bytes in memory.
class Inflater {
 public:
  explicit Inflater(std::string_view compressed) : left_(compressed) {
    constexpr int kGzip = 16;  // a header of gzip, none of zlib
    is_ready_ = inflateInit2(&stream_, kGzip + MAX_WBITS) == Z_OK;
  }
  ~Inflater() { inflateEnd(&stream_); }
  Inflater(const Inflater&) = delete;
  Inflater& operator=(const Inflater&) = delete;

  bool is_at_end() const { return left_.empty() && is_member_done_; }

  /// Fills the front of `piece` and returns how much of it [bytes]; none when what comes is damaged.
  std::optional<std::size_t> next(std::string& piece) {
    constexpr std::size_t kMost = std::numeric_limits<unsigned>::max();
    if (is_member_done_ && inflateReset(&stream_) != Z_OK) return std::nullopt;
    const auto given = static_cast<unsigned>(std::min(left_.size(), kMost));
    // zlib does not write there.
    stream_.next_in = reinterpret_cast<Bytef*>(const_cast<char*>(left_.data()));
    stream_.avail_in = given;
    stream_.next_out = reinterpret_cast<Bytef*>(piece.data());
    stream_.avail_out = static_cast<unsigned>(piece.size());
    const int result = is_ready_ ? inflate(&stream_, Z_NO_FLUSH) : Z_STREAM_ERROR;
    left_.remove_prefix(given - stream_.avail_in);
    is_member_done_ = result == Z_STREAM_END;
    if (result != Z_OK && result != Z_STREAM_END) return std::nullopt;
    return piece.size() - stream_.avail_out;
  }

 private:
  z_stream stream_{};
  std::string_view left_;
  bool is_ready_ = false;
  bool is_member_done_ = false;
};

}  // namespace

std::string gunzip(const std::filesystem::path& path, std::string_view compressed) {
  constexpr std::size_t kPiece = std::size_t{1} << 18;  // [bytes]
  const std::uint64_t most = greatest_expansion(compressed.size());
  Inflater inflater(compressed);
  std::string piece(kPiece, '\0');
  std::string content;
  while (!inflater.is_at_end()) {
    const std::optional<std::size_t> size = inflater.next(piece);
    if (!size) throw FileError(path, "is damaged inside its gzip compression; copy it again");
    if (content.size() + *size > most)
      throw FileError(path,
                      "grows more than 64-fold when it is unpacked; unpack it by gunzip if you trust it");
    content.append(piece, 0, *size);
  }
  return content;
}

#else

std::string gunzip(const std::filesystem::path& path, std::string_view /*compressed*/) {
  throw FileError(path, "is compressed, and this evermap was built without zlib; unpack it by gunzip");
}

#endif

}  // namespace evermap
