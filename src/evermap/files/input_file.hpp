// SPDX-FileCopyrightText: 2026 the evermap authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <filesystem>
#include <fstream>
#include <string>
#include <string_view>

#include <evermap/files/file_error.hpp>

namespace evermap {

/// A file that is read piece by piece. The constructor throws FileError when there is no such file, or it is
/// no regular file, empty or unreadable.
class InputStream {
 public:
  explicit InputStream(std::filesystem::path path);

  const std::filesystem::path& path() const { return path_; }
  std::uint64_t position() const { return position_; }      ///< [bytes]
  std::uint64_t rest() const { return size_ - position_; }  ///< [bytes] that follow

  /// Reads the next `size` bytes to the end of the buffer. REQUIRES: size <= rest(). Throws FileError when
  /// they cannot be read, or are no longer there.
  void append_to(std::string& buffer, std::size_t size);

 private:
  std::filesystem::path path_;
  std::ifstream stream_;
  std::uint64_t size_;
  std::uint64_t position_ = 0;
};

/// A whole file in memory, and the way to say what is wrong in it.
///
/// A copy instead of a memory map, because a map kills the process when the file shrinks meanwhile. The
/// constructor throws FileError like InputStream's.
class InputFile {
 public:
  explicit InputFile(std::filesystem::path path);

  const std::filesystem::path& path() const { return path_; }
  std::string_view bytes() const { return bytes_; }

  [[noreturn]] void fail(const std::string& message) const { throw FileError(path_, message); }
  [[noreturn]] void fail_at_byte(std::uint64_t offset, const std::string& message) const {
    throw FileError::at_byte(path_, offset, message);
  }
  [[noreturn]] void fail_at_line(std::uint64_t line, const std::string& message) const {
    throw FileError::at_line(path_, line, message);
  }

 private:
  std::filesystem::path path_;
  std::string bytes_;
};

}  // namespace evermap
