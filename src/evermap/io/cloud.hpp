// SPDX-FileCopyrightText: 2026 the evermap authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <filesystem>
#include <optional>
#include <string_view>

#include <evermap/scan/scan.hpp>

namespace evermap {

/// The extensions that read_cloud knows, for messages.
inline constexpr std::string_view kCloudExtensions = ".bin (KITTI), .pcd and .ply";

/// The extension of `path` in lower case when read_cloud knows it, none otherwise. Does not look at the file.
std::optional<std::string_view> cloud_extension(const std::filesystem::path& path);

/// Reads a point cloud or scan; the format follows from the extension (.bin .pcd .ply, any case).
/// Throws FileError when the file is missing, malformed or of another kind. Thread safe.
Scan read_cloud(const std::filesystem::path& path);

}  // namespace evermap
