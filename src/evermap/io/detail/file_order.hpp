// SPDX-FileCopyrightText: 2026 the evermap authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <filesystem>
#include <functional>
#include <vector>

namespace evermap {

/// The regular files of a folder that are wanted, in the order of their names, counted as a person counts:
/// 2.pcd before 10.pcd. Hidden files are none: archivers and file servers leave them beside the real ones
/// under the same extension. Throws FileError when the folder cannot be listed.
std::vector<std::filesystem::path> files_in(const std::filesystem::path& folder,
                                            const std::function<bool(const std::filesystem::path&)>& wanted);

}  // namespace evermap
