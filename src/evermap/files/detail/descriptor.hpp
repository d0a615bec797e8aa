// SPDX-FileCopyrightText: 2026 the evermap authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <filesystem>
#include <string_view>

namespace evermap {

/// As ::open, whatever signals come meanwhile; `permissions` are those of a new file, before the user's
/// umask.
int open_descriptor(const std::filesystem::path& path, int flags, unsigned permissions = 0666);

/// Writes all bytes to a file descriptor, or makes what was written to it last, whatever signals come
/// meanwhile. Return 0, or the number of the error.
int write_all(int descriptor, std::string_view bytes);
int sync_to_device(int descriptor);

}  // namespace evermap
