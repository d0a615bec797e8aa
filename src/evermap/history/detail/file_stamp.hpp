// SPDX-FileCopyrightText: 2026 the evermap authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <filesystem>

namespace evermap {

/// Tells a file from the one that takes its name later, and its content from what is written into it later.
/// Of no file it is the default.
struct FileStamp {
  std::uint64_t device = 0;
  std::uint64_t inode = 0;
  std::int64_t size = 0;     ///< [bytes]
  std::int64_t changed = 0;  ///< [ns] of the last change, since 1970

  bool operator==(const FileStamp&) const = default;
};
FileStamp stamp_of(const std::filesystem::path& file);

}  // namespace evermap
