// SPDX-FileCopyrightText: 2026 the evermap authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <bit>
#include <cstddef>
#include <span>
#include <vector>

#include <evermap/files/detail/ply_header.hpp>

namespace evermap {

/// The values of one row, property by property; a list has as many as its count says.
class PlyRow {
 public:
  std::span<const double> operator[](std::size_t property) const {
    const std::size_t begin = property == 0 ? 0 : ends_[property - 1];
    return {values_.data() + begin, ends_[property] - begin};
  }

 private:
  friend class PlyReader;
  std::vector<double> values_;
  std::vector<std::size_t> ends_;  ///< of each property in `values_`
};

/// Walks the data of a PLY file, ascii (one row a line) or binary of either byte order, in the order of the
/// header: every element is read, row by row, or skipped. Keeps a reference to the file. Not thread safe.
class PlyReader {
 public:
  /// Reads the header. Throws FileError naming the line that is wrong.
  explicit PlyReader(const InputFile& file);

  const std::vector<PlyElement>& elements() const { return header_.elements; }
  bool is_ascii() const { return header_.encoding == PlyEncoding::kAscii; }
  std::endian order() const {
    return header_.encoding == PlyEncoding::kBinaryBigEndian ? std::endian::big : std::endian::little;
  }

  /// Replaces `row` by the next one, or steps over all rows of the element. REQUIRES: it is `element`'s turn.
  /// Throws FileError where the data is damaged or ends; takes no more memory than a small multiple of what
  /// is there, whatever a list claims.
  void read_row(const PlyElement& element, PlyRow& row);
  void skip(const PlyElement& element);

  /// Where the data goes on, for whoever reads rows that are all of one size without PlyRow.
  TextLines& lines() { return lines_; }           ///< of an ascii file
  std::size_t offset() const { return offset_; }  ///< [bytes] in a binary file

 private:
  void read_text_row(const PlyElement& element, PlyRow& row);
  void read_binary_row(const PlyElement& element, PlyRow& row);
  void next_line(const PlyElement& element);
  [[noreturn]] void fail_at_end(const PlyElement& element, std::size_t offset) const;
  /// Steps over values of a binary file and gives the first one's place.
  const char* take(const PlyElement& element, std::uint64_t count, std::size_t size);

  const InputFile& file_;
  TextLines lines_;
  PlyHeader header_;
  std::size_t offset_;  ///< [bytes] at most the file's size
};

}  // namespace evermap
