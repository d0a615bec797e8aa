// SPDX-FileCopyrightText: 2026 the evermap authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <filesystem>

namespace evermap {

/// Where a map file is kept that is about to be replaced: `map.evm.undo` beside `map.evm`.
std::filesystem::path undo_path(const std::filesystem::path& map);

/// Keeps a map file as it is now, so that undo_map can bring it back after it was replaced; what was kept
/// before is dropped. A hard link where the file system has them: no bytes are copied. Does nothing when
/// there is no such file. At any crash, what is kept is a whole map. Throws FileError.
void keep_for_undo(const std::filesystem::path& map);

/// Brings back the map that was kept, bit for bit, in one step, and keeps none. Throws FileError when none
/// was kept, or when it is damaged: then nothing changes.
void undo_map(const std::filesystem::path& map);

}  // namespace evermap
