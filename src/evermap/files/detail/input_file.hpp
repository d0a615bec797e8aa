// SPDX-FileCopyrightText: 2026 the evermap authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <string>
#include <string_view>

#include <evermap/files/file_error.hpp>

namespace evermap {

/// A file that is read piece by piece: the one that had this name when it was opened, whatever is put in its
/// place meanwhile. The constructor throws FileError when there is no such file, or it is no regular file (a
/// pipe, which could keep us waiting for ever), empty or unreadable.
class InputStream {
 public:
  explicit InputStream(std::filesystem::path path);
  ~InputStream();
  InputStream(const InputStream&) = delete;
  InputStream& operator=(const InputStream&) = delete;

  const std::filesystem::path& path() const { return path_; }
  std::uint64_t position() const { return position_; }      ///< [bytes]
  std::uint64_t rest() const { return size_ - position_; }  ///< [bytes] that follow

  /// Goes on at another place. REQUIRES: position <= position() + rest().
  void seek(std::uint64_t position);
  /// Reads the next `size` bytes to the end of the buffer. REQUIRES: size <= rest(). Throws FileError when
  /// they cannot be read, are no longer there, or there is no memory for them.
  void append_to(std::string& buffer, std::uint64_t size);

 private:
  void open();

  std::filesystem::path path_;
  int descriptor_ = -1;
  std::uint64_t size_ = 0;
  std::uint64_t position_ = 0;
};

/// A whole file in memory, unpacked where its name ends with .gz, and the way to say what is wrong in it.
///
/// A copy instead of a memory map, because a map kills the process when the file shrinks meanwhile. The
/// constructor throws FileError like InputStream's, and when the file is larger than half of the machine's
/// memory.
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
