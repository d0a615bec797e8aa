// SPDX-FileCopyrightText: 2026 the evermap authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstddef>
#include <filesystem>
#include <string>
#include <string_view>

namespace evermap {

/// Replaces a file in one step: whoever opens `path`, at any moment and after any crash, finds the whole old
/// file or the whole new one.
///
/// Bytes go to a temporary file in the same folder; `commit()` syncs it, renames it over `path` and syncs the
/// folder. Without `commit()` the destructor removes the temporary file and `path` is as it was. A symbolic
/// link stays and what it points to is replaced; permission bits of a replaced file are kept. Every failure
/// (no such folder, read-only, no regular file, device full) throws FileError naming `path`. Not thread safe.
class AtomicFile {
 public:
  explicit AtomicFile(std::filesystem::path path);
  ~AtomicFile();
  AtomicFile(const AtomicFile&) = delete;
  AtomicFile& operator=(const AtomicFile&) = delete;

  void write(const void* data, std::size_t size);
  void write(std::string_view text) { write(text.data(), text.size()); }
  /// REQUIRES: called at most once, and nothing is written after it. When it throws, the old file is still in
  /// place, except that after a failed sync of the folder the new one already is.
  void commit();

 private:
  void open_temporary(unsigned permissions);
  void write_through(const char* data, std::size_t size);
  void flush();
  void close();
  [[noreturn]] void fail(int error, const std::string& what) const;

  std::filesystem::path path_;            ///< as the caller named it, for messages
  std::filesystem::path target_;          ///< `path_` with symbolic links followed
  std::filesystem::path temporary_path_;  ///< empty once it has become the target
  int descriptor_ = -1;                   ///< of the temporary file; -1 when closed
  std::string buffer_;
};

/// Makes a folder and those above it, where they are missing. Throws FileError.
void make_folder(const std::filesystem::path& path);

/// Makes renames in the folder of a file last. Throws FileError naming the file.
void sync_folder_of(const std::filesystem::path& file);

/// Removes the temporary files that killed processes left in the folder of a file; those of the living stay.
void remove_leftovers_beside(const std::filesystem::path& file);

}  // namespace evermap
