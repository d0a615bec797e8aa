// SPDX-FileCopyrightText: 2026 the evermap authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <filesystem>
#include <string>
#include <string_view>

namespace evermap {

/// Whether a file's name says that it is compressed with gzip, and the name without that: scan.bin of
/// scan.bin.gz, any other as it is.
bool is_gzip(const std::filesystem::path& path);
std::filesystem::path without_gzip(const std::filesystem::path& path);

/// What `compressed`, the content of the file `path`, holds: one member of gzip or several, one after the
/// other. Throws FileError when it is damaged, holds more than greatest_expansion() allows, or this build is
/// without zlib.
std::string gunzip(const std::filesystem::path& path, std::string_view compressed);

}  // namespace evermap
