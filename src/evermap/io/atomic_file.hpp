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
/// folder. Without `commit()` the destructor removes the temporary file and `path` is as it was. Every
/// failure (no such folder, read-only, device full) throws IoError naming `path`. Not thread safe.
class AtomicFile {
 public:
  explicit AtomicFile(std::filesystem::path path);
  ~AtomicFile();
  AtomicFile(const AtomicFile&) = delete;
  AtomicFile& operator=(const AtomicFile&) = delete;

  void write(const void* data, std::size_t size);
  void write(std::string_view text) { write(text.data(), text.size()); }
  void commit();

 private:
  void flush();

  std::filesystem::path path_;
  std::filesystem::path temporary_path_;
  int descriptor_ = -1;
  std::string buffer_;
};

}  // namespace evermap
